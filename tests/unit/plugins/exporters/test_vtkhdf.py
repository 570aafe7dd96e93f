"""One file with all frames: what h5py and VTK read back, and how it is continued."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
import pyvista

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import VTKHDFExporter
from rbs_plugins.exporters import growing, series
from rbs_plugins.fields import damage, displacement, kinetic_energy

stress = rbs.Field("stress", "node", "tensor", "Pa", "s", "A test.")


class Move(rbs.Integrator):
    """Displaces node i by (i + 1) t along x, and counts."""

    updates = (displacement, damage)

    def apply(self, clock):
        self[displacement][:, 0] = np.arange(1, len(self.part) + 1) * clock.time
        self[damage][...] = clock.step


def scene(path, dimension=2, precision="double", steps=3, when=rbs.always, **options):
    part = rbs.Part("body", rbs.Box(size=[4.0] * dimension), precision=precision).discretize(1.0)
    part[stress] = np.arange(dimension**2).reshape(dimension, dimension)
    exporter = VTKHDFExporter(part, [displacement, damage, stress], path / "frames", when=when, **options)
    checkpoint = rbs.Checkpoint(path / "state.npz", when=rbs.every(2))
    return part, rbs.Analysis([Move(part), exporter, checkpoint], dt=0.5, steps=steps)


def contents(path):
    """Every array of a file, by name."""
    found = {}
    with h5py.File(path / "frames.vtkhdf") as file:
        file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
        found["steps"] = int(file["VTKHDF/Steps"].attrs["NSteps"])
    return found


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


def test_the_name_of_the_file(tmp_path):
    part = rbs.Part("body", rbs.Box(size=[4.0, 4.0])).discretize(1.0)
    for given, made in (("a", "a.vtkhdf"), ("a.vtkhdf", "a.vtkhdf"), ("v1.2", "v1.2.vtkhdf")):
        assert VTKHDFExporter(part, (), tmp_path / given).path == tmp_path / made
    assert VTKHDFExporter(part, (), tmp_path / "a").label == "VTKHDFExporter 'body' a.vtkhdf"


@pytest.mark.parametrize(("field", "cure"), [(rbs.intact, "there are"), ("damage", "import damage"), (3, "exported")])
def test_only_fields_of_nodes_and_of_the_part(field, cure, tmp_path):
    part = rbs.Part("body", rbs.Box(size=[4.0, 4.0])).discretize(1.0).connect(1.0)
    with pytest.raises(BadInput, match=f"is no node field and no number of the part: .*{cure}"):
        VTKHDFExporter(part, [field], tmp_path / "frames")


def test_a_folder_that_cannot_be_written_is_an_error_before_the_run(tmp_path):
    part = rbs.Part("body", rbs.Box(size=[4.0, 4.0])).discretize(1.0)
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(BadInput, match="cannot write into the folder"):
        rbs.Analysis([VTKHDFExporter(part, (), tmp_path / "file" / "frames")]).prepare()


# -- interrupted, and looked at -------------------------------------------------------------------------------------


def reading(path):
    """A reader of VTK, and what it has read."""
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader


def test_a_viewer_that_has_the_file_open_does_not_stop_the_run(tmp_path):
    fcntl = pytest.importorskip("fcntl")
    _, analysis = scene(tmp_path, steps=4)
    analysis.run(steps=2, progress=False)
    with (tmp_path / "frames.vtkhdf").open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_SH)  # as HDF5 does it for a reader
        analysis.run(progress=False)
    assert reading(tmp_path / "frames.vtkhdf").GetNumberOfSteps() == 4


def killed(tmp_path, monkeypatch, moment, **options):
    """What a process that is killed at some moment of its third frame leaves on the disk: the file at that moment."""
    path, left, header = tmp_path / "frames.vtkhdf", tmp_path / "left", []
    _, analysis = scene(tmp_path, steps=2, **options)
    analysis.run(progress=False)
    original = growing.resized

    def look(file, name, rows):
        header[:] = header or [path.read_bytes()[:48]]
        if moment == "values" and name == "VTKHDF/Steps/NumberOfParts":  # they are there, and no index knows them
            left.write_bytes(path.read_bytes())
        elif moment != "values" and name == "VTKHDF/Steps/Values":  # all is there, and does not count yet
            whole = path.read_bytes()
            left.write_bytes(header[0] + whole[48:] if moment == "index" else whole)  # HDF5 writes its header last
        return original(file, name, rows)

    monkeypatch.setattr(growing, "resized", look)
    analysis.run(steps=3, progress=False)
    monkeypatch.undo()
    left.replace(path)
    return path


@pytest.mark.parametrize("compression", [None, "gzip"])
@pytest.mark.parametrize("configuration", ["reference", "current"])
@pytest.mark.parametrize("moment", ["values", "index", "header"])
def test_a_killed_process_leaves_its_frames_and_can_be_resumed(
    tmp_path, monkeypatch, moment, configuration, compression
):
    options = {"configuration": configuration, "compression": compression}
    path = killed(tmp_path, monkeypatch, moment, **options)
    assert moment == "values" or growing.was_closed(path) == (moment == "header")
    reader = reading(path)
    assert reader.GetNumberOfSteps() == 2
    for step in (0, 1):
        reader.SetStep(step)
        reader.Update()
        assert reader.GetOutput().GetPointData().GetArray("damage").GetValue(0) == step + 1
    scene(tmp_path, steps=5, **options)[1].run(progress=False, resume=tmp_path / "state.npz")
    assert growing.was_closed(path)
    (tmp_path / "whole").mkdir()
    scene(tmp_path / "whole", steps=5, **options)[1].run(progress=False)
    one, two = contents(tmp_path / "whole"), contents(tmp_path)
    assert one.keys() == two.keys()
    assert all(np.array_equal(one[name], two[name]) for name in one)


def test_frames_behind_the_checkpoint_go_before_the_first_step(tmp_path):
    scene(tmp_path, steps=3)[1].run(progress=False)
    assert contents(tmp_path)["steps"] == 3
    part, analysis = scene(tmp_path, steps=2)
    analysis.run(progress=False, resume=tmp_path / "state.npz")  # there is no step to do
    found = contents(tmp_path)
    assert found["steps"] == len(found["VTKHDF/Steps/Values"]) == 2
    assert len(found["VTKHDF/PointData/damage"]) == 2 * len(part)


def test_an_old_file_stays_until_the_first_frame_of_a_new_run(tmp_path, monkeypatch):
    scene(tmp_path, steps=3)[1].run(progress=False)
    scene(tmp_path, steps=1, when=rbs.every(2))[1].run(progress=False)
    monkeypatch.setattr(series, "append", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        scene(tmp_path, steps=1)[1].run(progress=False)
    monkeypatch.undo()
    assert contents(tmp_path)["steps"] == 3
    assert {path.name for path in tmp_path.iterdir()} == {"frames.vtkhdf", "state.npz"}


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda path: path.write_text("no HDF5"), "cannot be continued"),
        (lambda path: h5py.File(path, "w").close(), "is no series of frames"),
        (lambda path: other(path, dimension=1), "has 4 nodes instead of 16"),
        (lambda path: other(path, precision="single"), r"holds .*float32.* instead of .*float64"),
        (lambda path: other(path, steps=1), "holds 1:"),
        (lambda path: other(path, when=rbs.every(2), steps=4), "holds the time 1.0 s instead of 0.5 s"),
    ],
)
def test_a_foreign_file_is_refused_before_the_first_step(tmp_path, spoil, message):
    scene(tmp_path, steps=2)[1].run(progress=False)
    spoil(tmp_path / "frames.vtkhdf")
    before = (tmp_path / "frames.vtkhdf").read_bytes()
    _, analysis = scene(tmp_path, steps=5)
    with pytest.raises(BadInput, match=message):
        analysis.run(progress=False, resume=tmp_path / "state.npz")
    assert analysis.report.steps == 0
    assert (tmp_path / "frames.vtkhdf").read_bytes() == before


def other(path, **options):
    """Puts the file of another scene in the place of a file."""
    folder = path.with_name("other")
    folder.mkdir()
    scene(folder, **options)[1].run(progress=False)
    (folder / "frames.vtkhdf").replace(path)


def test_a_file_that_goes_away_is_an_error_that_names_it(tmp_path):
    _, analysis = scene(tmp_path)
    analysis.run(steps=1, progress=False)
    exporter = analysis.relations[1]
    (tmp_path / "frames.vtkhdf").unlink()
    with pytest.raises(OSError, match=r"VTKHDFExporter 'body' frames.vtkhdf cannot write .*frames.vtkhdf"):
        exporter.apply(analysis.clock)


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
