"""A moving body whose frames go into one file, and what can be read of that file: for tests."""

from __future__ import annotations

import h5py
import numpy as np

import rbs_core as rbs
from rbs_core.space import Cartesian
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


def reading(path):
    """A reader of VTK, and what it has read."""
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader


class Carry(rbs.Relation):
    """Turns the coordinate system of a part by a quarter and lifts it by 1 m, in every step."""

    def apply(self, clock):
        self.part.system.mapping = Cartesian((0.0, 0.0, clock.step), QUARTERS[clock.step % 4])


QUARTERS = [[(c, s, 0), (-s, c, 0), (0, 0, 1)] for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]


def carried():
    """A plate in a system that `Carry` moves, with a displacement of (0.25, 0), and where its two nodes are: (2, 3)."""
    system = rbs.world.child("carried")
    part = rbs.Part("plate", rbs.Box(size=(2.0, 1.0)), system=system).discretize(1.0)
    part[displacement] = (0.25, 0.0)

    def places(step):
        along, lift = np.array(QUARTERS[step % 4][0], float), np.array([0.0, 0.0, step])
        return np.array([-0.5 * along + lift, 0.5 * along + lift]), 0.25 * along

    return part, places
