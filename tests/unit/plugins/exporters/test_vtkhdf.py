"""One file with all frames: what h5py and VTK read back."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import Translation, VTKHDFExporter
from rbs_plugins.exporters import growing
from rbs_plugins.fields import displacement, kinetic_energy
from tests.unit.plugins.exporters.moving import Carry, Move, carried, contents, reading, scene, stress


@pytest.mark.parametrize("dimension", [1, 2, 3])
@pytest.mark.parametrize("configuration", ["reference", "current"])
def test_vtk_reads_every_frame(tmp_path, dimension, configuration):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOHDF import vtkHDFReader

    part, analysis = scene(tmp_path, dimension, configuration=configuration)
    analysis.run(progress=False)
    reader = vtkHDFReader()
    reader.SetFileName(str(tmp_path / "frames.vtkhdf"))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == 3
    reference = np.zeros((len(part), 3))
    reference[:, :dimension] = part.positions
    for step in range(3):
        reader.SetStep(step)
        reader.Update()
        data = reader.GetOutput()
        assert reader.GetTimeValue() == 0.5 * (step + 1)
        moved = np.zeros((len(part), 3))
        moved[:, 0] = np.arange(1, len(part) + 1) * 0.5 * (step + 1)
        points = vtk_to_numpy(data.GetPoints().GetData())
        np.testing.assert_allclose(points, reference + (moved if configuration == "current" else 0.0), atol=1e-14)
        values = data.GetPointData()
        np.testing.assert_array_equal(vtk_to_numpy(values.GetArray("displacement")), moved)
        assert (vtk_to_numpy(values.GetArray("damage")) == step + 1).all()
        tensor = vtk_to_numpy(values.GetArray("stress")).reshape(-1, 3, 3)
        np.testing.assert_array_equal(tensor[:, :dimension, :dimension], part[stress])
        assert data.GetNumberOfCells() == len(part)


def test_the_mesh_is_stored_once(tmp_path):
    part, analysis = scene(tmp_path, steps=5)
    analysis.run(progress=False)
    found = contents(tmp_path)
    n = len(part)
    assert found["VTKHDF/Points"].shape == (n, 3)
    assert found["VTKHDF/Connectivity"].shape == found["VTKHDF/Types"].shape == (n,)
    assert found["VTKHDF/PointData/displacement"].shape == (5 * n, 3)
    assert found["VTKHDF/Steps/Values"].tolist() == [0.5, 1.0, 1.5, 2.0, 2.5]


def test_single_precision_is_stored_as_such(tmp_path):
    _, analysis = scene(tmp_path, precision="single")
    analysis.run(progress=False)
    found = contents(tmp_path)
    assert found["VTKHDF/PointData/displacement"].dtype == np.float32
    assert found["VTKHDF/Points"].dtype == np.float64


def test_the_file_is_whole_after_every_frame(tmp_path):
    _, analysis = scene(tmp_path)
    for steps in (1, 2, 3):
        analysis.run(steps=steps, progress=False)
        assert contents(tmp_path)["steps"] == steps


def test_a_resumed_run_continues_its_file(tmp_path):
    (tmp_path / "whole").mkdir()
    (tmp_path / "parts").mkdir()
    scene(tmp_path / "whole", steps=5)[1].run(progress=False)
    scene(tmp_path / "parts", steps=3)[1].run(progress=False)  # a frame more than the checkpoint of step 2
    scene(tmp_path / "parts", steps=5)[1].run(progress=False, resume=tmp_path / "parts" / "state.npz")
    one, two = contents(tmp_path / "whole"), contents(tmp_path / "parts")
    assert one.keys() == two.keys()
    assert all(np.array_equal(one[name], two[name]) for name in one)


def test_another_file_is_not_continued(tmp_path):
    scene(tmp_path, steps=2)[1].run(progress=False)
    (tmp_path / "frames.vtkhdf").unlink()
    with pytest.raises(BadInput, match=r"should hold 2 frames of the run that goes on, and is not there"):
        scene(tmp_path, steps=5)[1].run(progress=False, resume=tmp_path / "state.npz")


def test_a_new_run_begins_a_new_file(tmp_path):
    scene(tmp_path, steps=4)[1].run(progress=False)
    scene(tmp_path, steps=1)[1].run(progress=False)
    assert contents(tmp_path)["steps"] == 1


@pytest.mark.parametrize(("name", "value"), [("precision", "half"), ("compression", "zip"), ("configuration", "past")])
def test_unknown_options(tmp_path, name, value):
    with pytest.raises(BadInput, match=f"{name}='{value}' must be one of"):
        scene(tmp_path, **{name: value})


def test_compressed_files_hold_the_same(tmp_path):
    (tmp_path / "plain").mkdir()
    (tmp_path / "small").mkdir()
    scene(tmp_path / "plain")[1].run(progress=False)
    scene(tmp_path / "small", compression="gzip")[1].run(progress=False)
    one, two = contents(tmp_path / "plain"), contents(tmp_path / "small")
    assert all(np.array_equal(one[name], two[name]) for name in one)


# -- what it takes, and in which coordinates ------------------------------------------------------------------------


@pytest.mark.parametrize(("precision", "size"), [(None, 8), ("double", 8), ("single", 4)])
@pytest.mark.parametrize("configuration", ["reference", "current"])
def test_precision_is_that_of_frames(tmp_path, precision, size, configuration):
    """Points that are stored once are double, points of every frame are as precise as the other arrays."""
    scene(tmp_path, precision="double", configuration=configuration)[1].run(progress=False)
    part = rbs.Part("body", rbs.Box(size=[4.0, 4.0])).discretize(1.0)
    part[displacement] = 1 / 3
    exporter = VTKHDFExporter(part, displacement, tmp_path / "frames", precision=precision, configuration=configuration)
    rbs.Analysis([exporter]).run(steps=2, dt=0.5, progress=False)
    found = contents(tmp_path)
    assert found["VTKHDF/PointData/displacement"].dtype.itemsize == size
    assert found["VTKHDF/Points"].dtype.itemsize == (size if configuration == "current" else 8)
    assert (found["VTKHDF/PointData/displacement"][:, :2] == np.dtype(f"f{size}").type(1 / 3)).all()


@pytest.mark.parametrize("dtype", ["uint8", "bool"])
def test_small_numbers_stay_small(tmp_path, dtype):
    flag = rbs.Field("flag", "node", "scalar", "1", "k", "A test.", dtype)
    part = rbs.Part("body", rbs.Box(size=[4.0, 4.0])).discretize(1.0)
    part[flag] = np.arange(len(part)) % 2
    rbs.Analysis([VTKHDFExporter(part, [flag, flag], tmp_path / "frames")]).run(steps=2, dt=0.5, progress=False)
    found = contents(tmp_path)["VTKHDF/PointData/flag"]
    assert found.dtype == np.uint8
    assert found.tolist() == [0, 1] * len(part)


@pytest.mark.parametrize("configuration", ["reference", "current"])
def test_no_fields_are_fields_too(tmp_path, configuration):
    part = rbs.Part("body", rbs.Box(size=[4.0, 4.0])).discretize(1.0)
    part[displacement] = 0.0
    exporter = VTKHDFExporter(part, (), tmp_path / "frames", configuration=configuration)
    rbs.Analysis([exporter]).run(steps=3, dt=0.5, progress=False)
    assert contents(tmp_path)["steps"] == 3
    assert reading(tmp_path / "frames.vtkhdf").GetOutput().GetNumberOfPoints() == len(part)


def test_a_turned_part_is_drawn_in_world_coordinates(tmp_path):
    """Positions and arrows turn together: a point displaced in the picture is a point plus its arrow."""
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])  # by an angle that tells it from its inverse
    turned = rbs.world.child("turned", origin=(1.0, 2.0, 3.0), axes=turn.T)
    part = rbs.Part("plate", rbs.Box(size=(2.0, 1.0)), system=turned, precision="single").discretize(1.0)
    part[displacement] = (0.25, 0.0)
    part[stress] = [[7.0, 3.0], [1.0, 0.0]]
    found = {}
    for configuration in ("reference", "current"):
        exporter = VTKHDFExporter(part, [displacement, stress], tmp_path / "frames", configuration=configuration)
        rbs.Analysis([exporter]).run(steps=1, dt=1.0, progress=False)
        found[configuration] = contents(tmp_path)
    still, moved = (found[name]["VTKHDF/Points"] for name in ("reference", "current"))
    values = found["reference"]["VTKHDF/PointData/displacement"]
    assert values.dtype == np.float32
    np.testing.assert_allclose(still, [[0.7, 1.6, 3.0], [1.3, 2.4, 3.0]], atol=1e-15)
    np.testing.assert_allclose(moved - still, values, atol=1e-7)
    np.testing.assert_allclose(values, [[0.15, 0.2, 0.0]] * 2, atol=1e-7)
    tensor = turn @ [[7.0, 3.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]] @ turn.T
    np.testing.assert_allclose(found["reference"]["VTKHDF/PointData/stress"][0].reshape(3, 3), tensor, atol=1e-6)


def test_a_part_whose_system_moves_is_where_it_is_at_the_frame(tmp_path):
    part, places = carried()
    exporter = VTKHDFExporter(part, [displacement], tmp_path / "frames", configuration="current")
    rbs.Analysis([Carry(part), exporter]).run(steps=3, dt=1.0, progress=False)
    found = contents(tmp_path)
    for step in (1, 2, 3):
        rows = slice(2 * step - 2, 2 * step)
        points, moved = places(step)
        np.testing.assert_allclose(found["VTKHDF/PointData/displacement"][rows], [moved, moved], atol=1e-15)
        np.testing.assert_allclose(found["VTKHDF/Points"][rows], points + moved, atol=1e-15)


def test_points_of_a_part_in_motion_are_not_stored_once(tmp_path):
    part, _ = carried()
    for system in (None, part.system):
        move = Translation(part, velocity=(1.0, 0.0), system=system)
        analysis = rbs.Analysis([move, VTKHDFExporter(part, (), tmp_path / "frames")])
        with pytest.raises(BadInput, match=r"the coordinate system of the part moves.*: take configuration='current'"):
            analysis.prepare()
    other = rbs.Part("other", rbs.Box(size=(2.0, 1.0))).discretize(1.0)
    rbs.Analysis([move, VTKHDFExporter(other, (), tmp_path / "other")]).prepare()


def test_whoever_moves_them_is_found_out(tmp_path):
    part, _ = carried()
    exporter = VTKHDFExporter(part, [displacement], tmp_path / "frames", when=rbs.every(4))
    analysis = rbs.Analysis([Carry(part), exporter])
    with pytest.raises(BadInput, match=r"the coordinate system of the part moves.*: take configuration='current'"):
        analysis.run(steps=8, dt=1.0, progress=False)
    assert contents(tmp_path)["steps"] == 1
    part.system.mapping = type(part.system.mapping)()  # back, and so the next run has a place for its points
    rbs.Analysis([exporter]).run(steps=8, dt=1.0, progress=False)
    assert contents(tmp_path)["steps"] == 2


def test_the_name_of_the_file(tmp_path):
    part = rbs.Part("body", rbs.Box(size=[4.0, 4.0])).discretize(1.0)
    for given, made in (("a", "a.vtkhdf"), ("a.vtkhdf", "a.vtkhdf"), ("v1.2", "v1.2.vtkhdf")):
        assert VTKHDFExporter(part, (), tmp_path / given).path == tmp_path / made
    assert VTKHDFExporter(part, (), tmp_path / "a").label == "VTKHDFExporter 'body' a.vtkhdf"


@pytest.mark.parametrize(
    ("field", "cure"), [(rbs.intact, "the nearest names are"), ("damage", "import damage"), (3, "exported")]
)
def test_only_fields_of_nodes_and_of_the_part(field, cure, tmp_path):
    part = rbs.Part("body", rbs.Box(size=[4.0, 4.0])).discretize(1.0).connect(1.0)
    with pytest.raises(BadInput, match=f"is no node field and no number of the part: .*{cure}"):
        VTKHDFExporter(part, [field], tmp_path / "frames")


def test_a_folder_that_cannot_be_written_is_an_error_before_the_run(tmp_path):
    part = rbs.Part("body", rbs.Box(size=[4.0, 4.0])).discretize(1.0)
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(BadInput, match="cannot write into the folder"):
        rbs.Analysis([VTKHDFExporter(part, (), tmp_path / "file" / "frames")]).prepare()


# -- radius, and numbers of the part --------------------------------------------------------------------------------

ends = rbs.Field("ends", "part", "vector", "m", "e", "A test.")


class Grow(rbs.Measure):
    """Numbers of the part that follow the step."""

    writes = (kinetic_energy, ends)

    def apply(self, clock):
        self[kinetic_energy][...] = clock.step
        self[ends][...] = (clock.step, -clock.step)


def rich(path, *, steps, nodes=4, **options):
    """A scene whose file has arrays of all kinds."""
    part = rbs.Part("body", rbs.Box(size=[float(nodes), 1.0])).discretize(1.0, thickness=0.1)
    fields = [kinetic_energy, displacement, ends]
    exporter = VTKHDFExporter(part, fields, path / "frames", radius=True, **options)
    scene = [Move(part), Grow(part), exporter, rbs.Checkpoint(path / "state.npz", when=rbs.every(2))]
    return part, rbs.Analysis(scene, dt=0.5, steps=steps)


@pytest.mark.parametrize("nodes", [1, 4])
@pytest.mark.parametrize("options", [{}, {"compression": "gzip"}, {"configuration": "current"}])
def test_vtk_reads_the_radius_and_the_numbers_of_the_part(tmp_path, options, nodes):
    part, analysis = rich(tmp_path, steps=3, nodes=nodes, **options)
    analysis.run(progress=False)
    reader = reading(tmp_path / "frames.vtkhdf")
    for step in range(3):
        reader.SetStep(step)
        reader.Update()
        data = pyvista.wrap(reader.GetOutput())
        assert data.field_data["kinetic_energy"].tolist() == [step + 1]
        assert data.field_data["ends"].tolist() == [[step + 1, -step - 1]]
        np.testing.assert_allclose(data["radius"], np.sqrt(1 / np.pi))
    assert contents(tmp_path)["VTKHDF/PointData/radius"].shape == (len(part),)  # once


@pytest.mark.parametrize("was_closed", [True, False])
def test_they_are_continued_as_well(tmp_path, was_closed, monkeypatch):
    for folder in ("whole", "parts"):
        (tmp_path / folder).mkdir()
    rich(tmp_path / "whole", steps=5)[1].run(progress=False)
    rich(tmp_path / "parts", steps=3)[1].run(progress=False)
    monkeypatch.setattr(growing, "was_closed", lambda _: was_closed)
    rich(tmp_path / "parts", steps=5)[1].run(progress=False, resume=tmp_path / "parts" / "state.npz")
    one, two = contents(tmp_path / "whole"), contents(tmp_path / "parts")
    assert one.keys() == two.keys()
    assert all(np.array_equal(one[name], two[name]) for name in one)


def test_a_file_without_the_radius_is_not_continued(tmp_path):
    rich(tmp_path, steps=2)[1].run(progress=False)
    _, analysis = rich(tmp_path, steps=4)
    analysis.relations[2].radius = False
    with pytest.raises(BadInput, match=r"holds \['Points', 'PointData/radius'\] once for all frames instead of"):
        analysis.run(progress=False, resume=tmp_path / "state.npz")
