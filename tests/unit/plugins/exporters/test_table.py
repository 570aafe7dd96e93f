"""CSV tables: what is in them, and that a resumed run continues them exactly."""

from __future__ import annotations

import pytest

import rbs_core as rbs
from rbs_core import BadInput, Field
from rbs_plugins import CSVExporter, read_table
from rbs_plugins.fields import damage, kinetic_energy

count = Field("count", "part", "scalar", "1", "n", "Made up for these tests.")
total = Field("total", "part", "vector", "N", "F", "Made up for these tests.")


class Counting(rbs.Measure):
    """Thirds, so that digits matter."""

    updates = (count,)
    writes = (total,)

    def apply(self, clock):
        self[count][...] += 1 / 3
        self[total][...] = [clock.time, -self[count]]


def scene(path, *more, when=rbs.always):
    part = rbs.Part("plate", rbs.Box(size=(2.0, 1.0))).discretize(1.0)
    return rbs.Analysis([Counting(part), CSVExporter(part, [count, total], path, when=when), *more])


def test_columns_and_rows(tmp_path):
    path = tmp_path / "deep" / "table.csv"
    scene(path, when=rbs.every(2)).run(steps=5, dt=0.1, progress=False)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "step,time,count,total_0,total_1"
    thirds, numbers = 0.0, []
    for step in range(1, 6):
        thirds += 1 / 3
        numbers.append([step, step * 0.1, thirds, step * 0.1, -thirds])
    table = read_table(path)
    assert list(table) == lines[0].split(",")
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
    for field in (damage, "kinetic_energy"):
        with pytest.raises(BadInput, match="no number of the part"):
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
