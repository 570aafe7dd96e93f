"""One file with all frames: what h5py and VTK read back, and how it is continued."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import VTKHDFExporter
from rbs_plugins.fields import damage, displacement

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
