"""Text files: names and units above, numbers below, one file per frame or one for all."""

from __future__ import annotations

import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput, Field
from rbs_plugins import TextExporter
from rbs_plugins.fields import damage, displacement, kinetic_energy, velocity

stress = Field("stress", "node", "tensor", "kg m/s", "σ", "Made up for these tests.")


class Move(rbs.Integrator):
    """A displacement of 1/3 of the time along x."""

    updates = (displacement,)

    def apply(self, clock):
        self[displacement][:, 0] = clock.time / 3


def scene(folder, steps, *more, **options):
    part = rbs.Part("plate", rbs.Box(size=(3.0, 2.0))).discretize(1.0)
    part[damage] = np.arange(6) / 6
    exporter = TextExporter(part, [displacement, damage], folder / "points", **options)
    return part, rbs.Analysis([Move(part), exporter, *more], dt=0.3, steps=steps)


@pytest.mark.parametrize("configuration", ["current", "reference"])
def test_a_file_for_each_frame(tmp_path, configuration):
    """Nine digits are good to 5e-9 of the number."""
    part, analysis = scene(tmp_path, 2, configuration=configuration)
    analysis.run(progress=False)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["points_000001.txt", "points_000002.txt"]
    lines = (tmp_path / "points_000002.txt").read_text(encoding="utf-8").splitlines()
    assert lines[:2] == [
        "# part 'plate', step 2, time 0.6 s",
        "# x[m] y[m] z[m] displacement_x[m] displacement_y[m] displacement_z[m] damage[1]",
    ]
    moved = part[displacement] if configuration == "current" else 0.0
    wanted = np.c_[part.positions + moved, np.zeros(6), part[displacement], np.zeros(6), part[damage]]
    np.testing.assert_allclose(np.loadtxt(tmp_path / "points_000002.txt"), wanted, rtol=6e-9)
    named = np.genfromtxt(tmp_path / "points_000002.txt", names=True, skip_header=1)
    np.testing.assert_allclose(named["damage1"], part[damage], rtol=6e-9)


def test_digits(tmp_path):
    _, analysis = scene(tmp_path, 1, digits=3)
    analysis.run(progress=False)
    assert (tmp_path / "points_000001.txt").read_text().splitlines()[3] == "0.1 -0.5 0 0.1 0 0 0.167"


def test_names_of_components_and_units_have_no_blanks(tmp_path):
    part = rbs.Part("bar", rbs.Box(size=2.0)).discretize(1.0)
    part[stress] = 7.0
    rbs.Analysis([TextExporter(part, stress, tmp_path / "bar", configuration="reference")]).run(
        steps=1, dt=1.0, progress=False
    )
    lines = (tmp_path / "bar_000001.txt").read_text(encoding="utf-8").splitlines()
    assert lines[1].split()[4:6] == ["stress_xx[kg*m/s]", "stress_xy[kg*m/s]"]
    assert lines[2] == "-0.5 0 0 7 0 0 0 0 0 0 0 0"


def test_a_turned_part_is_written_in_world_coordinates(tmp_path):
    turned = rbs.world.child("turned", origin=(1.0, 2.0, 3.0), axes=[(0, 1, 0), (-1, 0, 0), (0, 0, 1)])
    part = rbs.Part("bar", rbs.Box(size=2.0), system=turned).discretize(1.0)
    part[displacement] = 0.25
    rbs.Analysis([TextExporter(part, displacement, tmp_path / "bar")]).run(steps=1, dt=1.0, progress=False)
    np.testing.assert_allclose(
        np.loadtxt(tmp_path / "bar_000001.txt"), [[1, 1.75, 3, 0, 0.25, 0], [1, 2.75, 3, 0, 0.25, 0]], atol=1e-9
    )


def test_all_frames_in_one_file(tmp_path):
    _, analysis = scene(tmp_path, 3, one_file=True)
    analysis.run(progress=False)
    assert [path.name for path in tmp_path.iterdir()] == ["points.txt"]
    blocks = (tmp_path / "points.txt").read_text(encoding="utf-8").split("\n\n\n")
    assert [block.splitlines()[0] for block in blocks] == [
        f"# part 'plate', step {step}, time {step * 0.3!r} s" for step in (1, 2, 3)
    ]
    assert [len(np.loadtxt(block.splitlines())) for block in blocks] == [6, 6, 6]
    scene(tmp_path, 1, one_file=True)[1].run(progress=False)  # a new run starts anew
    assert (tmp_path / "points.txt").read_text(encoding="utf-8").count("step") == 1


@pytest.mark.parametrize("one_file", [True, False])
def test_resumed_runs_continue_to_the_byte(tmp_path, one_file):
    def run(folder, steps, **options):
        folder.mkdir(exist_ok=True)
        save = rbs.Checkpoint(folder / "save.npz", when=rbs.every(2))
        scene(folder, steps, save, one_file=one_file)[1].run(progress=False, **options)

    run(tmp_path / "whole", 5)
    run(tmp_path / "parts", 3)  # a frame behind the checkpoint
    run(tmp_path / "parts", 5, resume=tmp_path / "parts" / "save.npz")
    whole, parts = ({path.name: path.read_bytes() for path in (tmp_path / n).glob("*.txt")} for n in ("whole", "parts"))
    assert whole == parts


@pytest.mark.parametrize(
    "spoil",
    [
        lambda path: path.unlink(),
        lambda path: path.write_bytes(path.read_bytes()[:-1]),
        lambda path: path.write_text(path.read_text().replace("damage", "wear..")),
    ],
)
def test_another_file_is_not_continued(tmp_path, spoil):
    save = rbs.Checkpoint(tmp_path / "save.npz", when=rbs.last)
    scene(tmp_path, 2, save, one_file=True)[1].run(progress=False)
    spoil(tmp_path / "points.txt")
    with pytest.raises(BadInput, match=r"should hold \d+ bytes of the run that goes on"):
        scene(tmp_path, 3, save, one_file=True)[1].run(progress=False, resume=tmp_path / "save.npz")


@pytest.mark.parametrize("digits", [0, 16, 2.5, "9"])
def test_digits_are_checked(tmp_path, digits):
    with pytest.raises(BadInput, match="must be a whole number from 1 to 15"):
        scene(tmp_path, 1, digits=digits)


def test_the_name_of_one_file(tmp_path):
    part = rbs.Part("bar", rbs.Box(size=2.0)).discretize(1.0)
    for given, made in (("a", "a.txt"), ("a.dat", "a.dat")):
        assert TextExporter(part, (), tmp_path / given, one_file=True).path == tmp_path / made
    assert TextExporter(part, (), tmp_path / "a").label == "TextExporter 'bar' a"


@pytest.mark.parametrize("field", [kinetic_energy, rbs.intact, "velocty"])
def test_only_node_fields(field, tmp_path):
    part = rbs.Part("bar", rbs.Box(size=2.0)).discretize(1.0).connect(1.0)
    with pytest.raises(BadInput, match=r"is no node field: .*(nearest names are|there are)"):
        TextExporter(part, [velocity, field], tmp_path / "a")
