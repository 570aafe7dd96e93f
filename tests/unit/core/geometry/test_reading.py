"""Surfaces from files."""

from __future__ import annotations

import struct

import meshio
import numpy as np
import pytest

from rbs_core.errors import BadInput
from rbs_core.geometry import SurfaceMesh, TriangulatedSurface
from rbs_core.geometry.reading import joined, read_triangles
from tests.unit.core.geometry.examples import FACES, OCTAHEDRON


def write(path, cells=None, points=OCTAHEDRON, **options):
    meshio.write(path, meshio.Mesh(points, cells or [("triangle", np.array(FACES))]), **options)
    return path


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("a.stl", {"binary": True}),
        ("a.stl", {"binary": False}),
        ("a.ply", {}),
        ("a.obj", {}),
        ("a.vtk", {}),
        ("a.off", {}),
    ],
)
def test_files_of_other_programs(tmp_path, name, options):
    mesh = SurfaceMesh.read(write(tmp_path / name, **options))
    assert len(mesh.triangles) == 8
    assert len(mesh.vertices) == 6
    assert mesh.volume == pytest.approx(0.972, rel=1e-6)
    assert SurfaceMesh.read(str(tmp_path / name), unit=1e-3).volume == pytest.approx(0.972e-9, rel=1e-6)


def test_quadrilaterals_are_cut_in_two(tmp_path):
    corners = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    sides = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    mesh = SurfaceMesh.read(write(tmp_path / "cube.vtk", [("quad", sides)], corners))
    assert mesh.volume == pytest.approx(1.0)
    assert len(mesh.triangles) == 12


def test_open_surfaces_are_read_as_cuts(tmp_path):
    path = write(tmp_path / "roof.stl", [("triangle", np.array(FACES[:4]))])
    assert len(TriangulatedSurface.read(path).triangles) == 4
    with pytest.raises(BadInput, match=r"roof.stl: the surface is open: .*join vertices that coincide \(read"):
        SurfaceMesh.read(path)


def test_rounded_vertices_are_joined(tmp_path, rng):
    corners = OCTAHEDRON[np.array(FACES)].reshape(-1, 3)
    rough = corners + rng.uniform(-1e-6, 1e-6, corners.shape)
    path = write(tmp_path / "rough.ply", [("triangle", np.arange(24).reshape(-1, 3))], rough)
    with pytest.raises(BadInput, match=r"the surface is open"):
        SurfaceMesh.read(path)
    mesh = SurfaceMesh.read(path, join=1e-5)
    assert len(mesh.vertices) == 6
    assert mesh.volume == pytest.approx(0.972, rel=1e-5)


def test_triangles_that_collapse_are_left_out():
    vertices = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1e-9, 1, 0)], dtype=float)
    places, triangles = joined(vertices, np.array([(0, 1, 2), (1, 3, 2)]), 1e-6)
    assert places.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert triangles.tolist() == [[0, 1, 2]]


def refused(tmp_path, name: str, content: bytes | None = None, cells=None, **options):
    path = tmp_path / name
    if cells is not None:
        write(path, cells)
    elif content is not None:
        path.write_bytes(content)
    return read_triangles(path, **({"unit": 1.0, "join": 0.0} | options))


TETRAHEDRON = [("tetra", np.array([(0, 1, 2, 4)]))]
ONE_LINE = [("line", np.array([(0, 1)]))]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"name": "gone.stl"}, r"there is no file .*gone.stl; give the path of a surface, such as body.stl"),
        (
            {"name": "notes.txt", "content": b"hello"},
            r"notes.txt cannot be read \(.*\); give an STL, PLY",
        ),
        ({"name": "bad.stl", "content": b"solid x\nfacet"}, r"bad.stl (cannot be read|holds no triangles)"),
        (
            {"name": "short.stl", "content": b" " * 80 + struct.pack("<I", 5) + b"1234"},
            r"short.stl (cannot be read|holds no triangles)",
        ),
        ({"name": "solid.vtk", "cells": TETRAHEDRON}, r"holds cells of type 'tetra'; give a file with the triangles"),
        ({"name": "line.vtk", "cells": ONE_LINE}, r"line.vtk holds no triangles; give a file with the triangles"),
        ({"name": "a.stl", "unit": 0.0}, r"unit = 0.0 is not positive"),
        ({"name": "a.stl", "join": -1.0}, r"join = -1.0 is negative; give a length from 0"),
    ],
)
def test_refusals_say_what_where_and_cure(tmp_path, arguments, message):
    with pytest.raises(BadInput, match=message):
        refused(tmp_path, **arguments)
