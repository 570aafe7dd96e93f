"""CSV tables: what is in them, and that a resumed run continues them exactly."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Field
from rbs_plugins import CSVExporter, largest, mean, read_table, smallest, total
from rbs_plugins.fields import damage, displacement, kinetic_energy, volume

count = Field("count", "part", "scalar", "1", "n", "Made up for these tests.")
force = Field("force", "part", "vector", "N", "F", "Made up for these tests.")


class Counting(rbs.Measure):
    """Thirds, so that digits matter."""

    updates = (count,)
    writes = (force,)

    def apply(self, clock):
        self[count][...] += 1 / 3
        self[force][...] = [clock.time, -self[count]]


def scene(path, *more, when=rbs.always):
    part = rbs.Part("plate", rbs.Box(size=(2.0, 1.0))).discretize(1.0)
    return rbs.Analysis([Counting(part), CSVExporter(part, [count, force], path, when=when), *more])


def test_columns_and_rows(tmp_path):
    path = tmp_path / "deep" / "table.csv"
    scene(path, when=rbs.every(2)).run(steps=5, dt=0.1, progress=False)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "step,time [s],count [1],force_0 [N],force_1 [N]"
    thirds, numbers = 0.0, []
    for step in range(1, 6):
        thirds += 1 / 3
        numbers.append([step, step * 0.1, thirds, step * 0.1, -thirds])
    table = read_table(path)
    assert list(table) == ["step", "time", "count", "force_0", "force_1"]
    assert table.units == {"time": "s", "count": "1", "force_0": "N", "force_1": "N"}
    assert [list(row) for row in zip(*table.values(), strict=True)] == [numbers[1], numbers[3]]  # to the bit


def test_a_new_run_starts_the_file_anew(tmp_path):
    path = tmp_path / "table.csv"
    for steps in (5, 2):
        scene(path).run(steps=steps, dt=0.1, progress=False)
        assert read_table(path)["step"] == list(range(1, steps + 1))


def test_one_analysis_run_twice_goes_on(tmp_path):
    analysis = scene(tmp_path / "table.csv")
    analysis.run(steps=2, dt=0.1, progress=False)
    analysis.run(steps=4, dt=0.1, progress=False)
    assert read_table(tmp_path / "table.csv")["step"] == [1, 2, 3, 4]


@pytest.mark.parametrize(("saved", "stopped"), [(3, 3), (3, 5), (4, 5)])
def test_resumed_run_continues_to_the_byte(tmp_path, saved, stopped):
    """Rows behind the checkpoint are dropped and written again."""
    save = rbs.Checkpoint(tmp_path / "save.npz", when=rbs.every(saved))
    whole, parts = tmp_path / "whole.csv", tmp_path / "parts.csv"
    scene(whole).run(steps=9, dt=0.1, progress=False)
    scene(parts, save).run(steps=stopped, dt=0.1, progress=False)
    assert read_table(parts)["step"][-1] == stopped
    save = rbs.Checkpoint(tmp_path / "save.npz", when=rbs.last)
    scene(parts, save).run(steps=9, dt=0.1, progress=False, resume=tmp_path / "save.npz")
    assert parts.read_bytes() == whole.read_bytes()


def test_rows_are_there_while_the_run_goes_on(tmp_path):
    path = tmp_path / "table.csv"
    seen = []

    class Look(rbs.Measure):
        """Reads the file that is being written."""

        def apply(self, clock):
            seen.append(len(path.read_text(encoding="utf-8").splitlines()))

    analysis = scene(path)
    analysis.append(Look(analysis.parts[0]))
    analysis.run(steps=3, dt=0.1, progress=False)
    assert seen == [2, 3, 4]


def test_file_is_whole_after_an_error(tmp_path):
    class Fail(rbs.Measure):
        """Breaks in step 3."""

        def apply(self, clock):
            if clock.step == 3:
                raise RuntimeError("broken on purpose")

    analysis = scene(tmp_path / "table.csv")
    analysis.append(Fail(analysis.parts[0]))
    with pytest.raises(RuntimeError, match="on purpose"):
        analysis.run(steps=5, dt=0.1, progress=False)
    assert read_table(tmp_path / "table.csv")["step"] == [1, 2, 3]


def test_only_numbers_of_the_part(tmp_path):
    part = rbs.Part("rod", rbs.Box(size=2.0)).discretize(1.0)
    for field, cure in (
        (damage, r"node fields do as total\(field\)"),
        ("kinetic_energy", "from rbs_plugins.fields import kinetic_energy"),
        ("kinetic", "the nearest names are kinetic_energy"),
    ):
        with pytest.raises(BadInput, match=f"no number of the part: .*{cure}"):
            CSVExporter(part, [field], tmp_path / "table.csv")
    assert CSVExporter(part, [kinetic_energy], tmp_path / "table.csv").reads == (kinetic_energy,)


def test_the_name_in_reports_tells_tables_apart(tmp_path):
    analysis = scene(tmp_path / "table.csv")
    report = analysis.run(steps=1, dt=0.1, progress=False)
    assert [row.name for row in report.rows] == ["Counting 'plate'", "CSVExporter 'plate' table.csv"]
    assert "\n 1 CSVExporter 'plate' table.csv " in str(report)
    with pytest.raises(BadInput, match=r"^CSVExporter 'plate' other.csv: .* fits no table"):
        CSVExporter(analysis.parts[0], [damage], tmp_path / "other.csv")


def test_folder_that_cannot_be_made_is_an_error_before_the_run(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(BadInput, match="cannot write into the folder"):
        scene(tmp_path / "file" / "table.csv").prepare()


# -- sums, means and extremes ---------------------------------------------------------------------------------------


class Growing(rbs.Integrator):
    """A displacement of node i of (i, -i) t, and a damage of i / n."""

    updates = (displacement, damage)

    def apply(self, clock):
        numbers = np.arange(len(self.part))
        self[displacement][...] = np.stack([numbers, -numbers], axis=1) * clock.time
        self[damage][...] = numbers / len(numbers)


def test_a_table_of_numbers_of_the_part_and_of_nodes(tmp_path):
    part = rbs.Part("plate", rbs.Box(size=(4.0, 1.0))).discretize(1.0, thickness=0.5)
    left = rbs.HalfSpace((0.0, 0.0), normal=(-1.0, 0.0))
    fields = [
        count,
        total(displacement),
        mean(damage, left, name="damage_left"),
        largest(displacement, [1, 2], component="magnitude"),
        total(damage, weights=volume, name="damaged"),
    ]
    exporter = CSVExporter(part, fields, tmp_path / "table.csv")
    assert exporter.reads == (count, displacement, damage, volume)
    rbs.Analysis([Growing(part), Counting(part), exporter]).run(steps=2, dt=0.5, progress=False)
    table = read_table(tmp_path / "table.csv")
    assert table == {
        "step": [1, 2],
        "time": [0.5, 1.0],
        "count": [1 / 3, 2 / 3],
        "total_displacement_x": [3.0, 6.0],
        "total_displacement_y": [-3.0, -6.0],
        "damage_left": [0.125, 0.125],
        "largest_displacement_magnitude": [2**0.5, 2 * 2**0.5],
        "damaged": [0.75, 0.75],
    }
    assert table.units["damaged"] == "m^3"
    assert table.units["total_displacement_x"] == "m"


def test_resumed_tables_of_nodes_continue_to_the_byte(tmp_path):
    def scene(name, *more):
        part = rbs.Part("plate", rbs.Box(size=(40.0, 10.0))).discretize(1.0)
        fields = [total(displacement), mean(damage, weights=volume), smallest(displacement, component="y")]
        return rbs.Analysis([Growing(part), CSVExporter(part, fields, tmp_path / name), *more])

    scene("whole.csv").run(steps=9, dt=0.1, progress=False)
    scene("parts.csv", rbs.Checkpoint(tmp_path / "save.npz", when=rbs.every(3))).run(steps=5, dt=0.1, progress=False)
    scene("parts.csv").run(steps=9, dt=0.1, progress=False, resume=tmp_path / "save.npz")
    assert (tmp_path / "parts.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


@pytest.mark.parametrize(
    "fields", [[count, count], [mean(damage), mean(damage, [1])], [total(damage, name="time")]], ids=str
)
def test_columns_have_names_of_their_own(fields, tmp_path):
    part = rbs.Part("plate", rbs.Box(size=(4.0, 1.0))).discretize(1.0)
    with pytest.raises(BadInput, match=r"2 columns would be called '.*': give each its own"):
        CSVExporter(part, fields, tmp_path / "table.csv")


def test_a_name_with_a_comma_is_one_column(tmp_path):
    part = rbs.Part("plate", rbs.Box(size=(4.0, 1.0))).discretize(1.0)
    for steps in (2, 3):  # the second goes on in the file of the first
        table = CSVExporter(part, [total(damage, name="damage, left")], tmp_path / "table.csv")
        save = rbs.Checkpoint(tmp_path / "save.npz", when=rbs.last)
        analysis = rbs.Analysis([Growing(part), table, save])
        analysis.run(steps=steps, dt=0.1, progress=False, resume=tmp_path / "save.npz")
    assert read_table(tmp_path / "table.csv")["damage, left"] == [1.5, 1.5, 1.5]


def test_a_table_of_an_older_version_has_no_units(tmp_path):
    (tmp_path / "old.csv").write_text("step,time,energy\n1,0.5,2.0\n")
    table = read_table(tmp_path / "old.csv")
    assert table == {"step": [1.0], "time": [0.5], "energy": [2.0]}
    assert table.units == {}
