"""VTK files, read back by two other programs."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import meshio
import numpy as np
import pytest
import pyvista

import rbs_core as rbs
from rbs_core import BadInput, Field, NotFinite
from rbs_plugins import VTKExporter
from rbs_plugins.fields import damage, displacement, kinetic_energy, velocity
from tests.unit.plugins.exporters.moving import Carry, carried

stress = Field("stress", "node", "tensor", "Pa", "σ", "Made up for these tests.")


@pytest.fixture(params=[1, 2, 3])
def part(request, rng):
    made = rbs.Part("block", rbs.Box(size=(4.0, 3.0, 2.0)[: request.param])).discretize(1.0).connect(1.0)
    made[displacement] = rng.normal(size=made.positions.shape)
    made[velocity] = rng.normal(size=made.positions.shape)
    made[damage] = rng.uniform(size=len(made))
    made[stress] = rng.normal(size=(len(made), request.param, request.param))
    return made


def export(part, path, steps=3, when=rbs.always, **options):
    exporter = VTKExporter(part, [damage, velocity, stress], path, when=when, **options)
    rbs.Analysis([exporter]).run(steps=steps, dt=0.1, progress=False)
    return exporter


def padded(array):
    """With zeros for the missing directions."""
    full = np.zeros((len(array),) + (3,) * (array.ndim - 1))
    full[(slice(None), *(slice(0, n) for n in array.shape[1:]))] = array
    return full.reshape(len(array), -1) if array.ndim == 3 else full


@pytest.mark.parametrize("configuration", ["current", "reference"])
def test_files_hold_what_the_part_holds(part, tmp_path, configuration):
    export(part, tmp_path / "out" / "block", configuration=configuration)
    moved = part[displacement] if configuration == "current" else 0.0
    points = padded(part.positions + moved)
    mesh = meshio.read(tmp_path / "out" / "block_000002.vtu")
    grid = pyvista.read(tmp_path / "out" / "block_000002.vtu")
    for found, data in ((mesh.points, mesh.point_data), (grid.points, grid.point_data)):
        assert np.array_equal(found, points)
        assert np.array_equal(data["damage"], part[damage])
        assert np.array_equal(data["velocity"], padded(part[velocity]))
        assert np.array_equal(np.reshape(data["stress"], (len(part), -1)), padded(part[stress]))
        assert set(data) == {"damage", "velocity", "stress"}
    assert mesh.cells[0].type == "vertex"
    assert np.array_equal(mesh.cells[0].data.ravel(), np.arange(len(part)))
    assert grid.n_cells == len(part)


def test_the_name_in_reports_tells_series_apart(part, tmp_path):
    exporter = export(part, tmp_path / "out" / "frames", steps=1)
    assert exporter.label == "VTKExporter 'block' frames"
    with pytest.raises(BadInput, match=r"^VTKExporter 'block' frames: .* is no node field"):
        VTKExporter(part, [rbs.intact], tmp_path / "frames")


def test_series_lists_every_frame_with_its_time(part, tmp_path):
    export(part, tmp_path / "block", steps=7, when=rbs.every(3))
    tree = ElementTree.parse(tmp_path / "block.pvd")
    frames = [(float(each.get("timestep")), each.get("file")) for each in tree.iter("DataSet")]
    assert frames == [(3 * 0.1, "block_000003.vtu"), (6 * 0.1, "block_000006.vtu")]  # 0.30000000000000004 to the bit
    reader = pyvista.get_reader(tmp_path / "block.pvd")
    assert list(reader.time_values) == [3 * 0.1, 6 * 0.1]
    reader.set_active_time_value(6 * 0.1)
    assert reader.read()[0].n_points == len(part)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["block.pvd", "block_000003.vtu", "block_000006.vtu"]


def test_frames_are_those_of_their_step(tmp_path):
    part = rbs.Part("dot", rbs.Everywhere(), dimension=1).place([[0.0]], 1.0)

    class Walk(rbs.Boundary):
        """One metre per step."""

        updates = (displacement,)

        def apply(self, clock):
            self[displacement][...] += 1.0

    rbs.Analysis([Walk(part), VTKExporter(part, [displacement], tmp_path / "dot")]).run(steps=3, dt=1.0, progress=False)
    for step in (1, 2, 3):
        grid = pyvista.read(tmp_path / f"dot_{step:06d}.vtu")
        assert grid.points.tolist() == [[step, 0.0, 0.0]]
        assert grid["displacement"].tolist() == [[step, 0.0, 0.0]]


def test_series_of_a_resumed_run_goes_on(tmp_path):
    def scene(folder):
        part = rbs.Part("dot", rbs.Everywhere(), dimension=1).place([[0.0]], 1.0)
        part[damage] = 0.5
        exporter = VTKExporter(part, [damage], folder / "dot", configuration="reference", when=rbs.every(2))
        return rbs.Analysis([exporter, rbs.Checkpoint(folder / "save.npz", when=rbs.every(3))])

    whole, parts = tmp_path / "whole", tmp_path / "parts"
    scene(whole).run(steps=9, dt=0.5, progress=False)
    scene(parts).run(steps=5, dt=0.5, progress=False)  # the last frame is of step 4, the checkpoint of step 3
    scene(parts).run(steps=9, dt=0.5, progress=False, resume=parts / "save.npz")
    assert (whole / "dot.pvd").read_text(encoding="utf-8") == (parts / "dot.pvd").read_text(encoding="utf-8")
    names = [each.get("file") for each in ElementTree.parse(parts / "dot.pvd").iter("DataSet")]
    assert names == [f"dot_{step:06d}.vtu" for step in (2, 4, 6, 8)]
    for name in names:
        assert (whole / name).read_bytes() == (parts / name).read_bytes()


def test_a_turned_part_is_drawn_in_world_coordinates(tmp_path):
    """Positions and arrows turn together: a point displaced in the picture is a point plus its arrow."""
    turned = rbs.world.child("turned", origin=(1.0, 2.0, 3.0), axes=[(0, 1, 0), (-1, 0, 0), (0, 0, 1)])
    part = rbs.Part("plate", rbs.Box(size=(2.0, 1.0)), system=turned).discretize(1.0).connect(1.0)
    part[displacement] = (0.25, 0.0)
    part[stress] = [[7.0, 3.0], [1.0, 0.0]]
    still = VTKExporter(part, [displacement, stress], tmp_path / "still", configuration="reference")
    moved = VTKExporter(part, [displacement], tmp_path / "moved")
    rbs.Analysis([still, moved]).run(steps=1, dt=1.0, progress=False)
    before, after = (pyvista.read(tmp_path / f"{name}_000001.vtu") for name in ("still", "moved"))
    np.testing.assert_allclose(before.points, [[1.0, 1.5, 3.0], [1.0, 2.5, 3.0]], atol=1e-15)
    np.testing.assert_allclose(after.points - before.points, [[0.0, 0.25, 0.0]] * 2, atol=1e-15)
    np.testing.assert_allclose(before["displacement"], after.points - before.points, atol=1e-15)
    # x of the plate is y of the world, y of the plate is -x of the world
    np.testing.assert_allclose(before["stress"][0].reshape(3, 3), [[0, -1, 0], [-3, 7, 0], [0, 0, 0]], atol=1e-14)


@pytest.mark.parametrize("configuration", ["current", "reference"])
def test_a_part_whose_system_moves_is_where_it_is_at_the_frame(tmp_path, configuration):
    part, places = carried()
    exporter = VTKExporter(part, [displacement], tmp_path / "plate", configuration=configuration)
    rbs.Analysis([Carry(part), exporter]).run(steps=3, dt=1.0, progress=False)
    for step in (1, 2, 3):
        grid = pyvista.read(tmp_path / f"plate_{step:06d}.vtu")
        points, moved = places(step)
        np.testing.assert_allclose(grid["displacement"], [moved, moved], atol=1e-15)
        np.testing.assert_allclose(grid.points, points + (moved if configuration == "current" else 0.0), atol=1e-15)


def test_names_that_xml_does_not_like(tmp_path):
    part = rbs.Part("dot", rbs.Everywhere(), dimension=1).place([[0.0]], 1.0)
    part[displacement] = 0.0
    rbs.Analysis([VTKExporter(part, (), tmp_path / 'a&b "c" <d>')]).run(steps=1, dt=1.0, progress=False)
    (found,) = ElementTree.parse(tmp_path / 'a&b "c" <d>.pvd').iter("DataSet")
    assert (tmp_path / found.get("file")).exists()


@pytest.mark.parametrize(
    ("field", "cure"),
    [
        (rbs.intact, "the nearest names are"),
        ("damage", "from rbs_plugins.fields import damage"),
        ("dispacement", "the nearest names are displacement"),
        ("kinetic_energie", "the nearest names are kinetic_energy"),
        (3, "only those can be exported as frames$"),
    ],
)
def test_what_is_no_field_is_refused_with_the_nearest_names(field, cure, tmp_path):
    part = rbs.Part("dots", rbs.Box(size=2.0)).discretize(1.0).connect(1.0)
    for given in (field, [field], [displacement, field]):
        with pytest.raises(BadInput, match=f"is no node field and no number of the part: .*{cure}"):
            VTKExporter(part, given, tmp_path / "dots")


def test_configuration_is_checked(tmp_path):
    part = rbs.Part("dots", rbs.Box(size=2.0)).discretize(1.0)
    with pytest.raises(BadInput, match="must be one of current, reference"):
        VTKExporter(part, (), tmp_path / "dots", configuration="deformed")


def test_folder_is_made_and_one_that_cannot_be_is_an_error_before_the_run(tmp_path):
    part = rbs.Part("dots", rbs.Box(size=2.0)).discretize(1.0)
    part[displacement] = 0.0
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(BadInput, match="cannot write into the folder"):
        rbs.Analysis([VTKExporter(part, (), tmp_path / "file" / "dots")]).prepare()
    rbs.Analysis([VTKExporter(part, (), tmp_path / "a" / "b" / "dots")]).run(steps=1, dt=1.0, progress=False)
    assert (tmp_path / "a" / "b" / "dots.pvd").exists()


def test_what_is_not_finite_never_reaches_a_file(tmp_path):
    part = rbs.Part("dots", rbs.Box(size=2.0)).discretize(1.0)
    part[displacement] = 0.0
    analysis = rbs.Analysis([VTKExporter(part, [displacement], tmp_path / "dots")])
    analysis.run(steps=1, dt=1.0, progress=False)
    part[displacement][1] = np.inf
    with pytest.raises(NotFinite, match="'displacement' of node 1"):
        analysis.run(steps=2, dt=1.0, progress=False)
    assert [path.name for path in tmp_path.glob("*.vtu")] == ["dots_000001.vtu"]


def test_numbers_of_the_part_become_field_data(tmp_path):
    ends = Field("ends", "part", "vector", "m", "e", "Made up for these tests.")
    part = rbs.Part("dots", rbs.Box(size=(2.0, 1.0))).discretize(1.0)
    part[damage], part[kinetic_energy], part[ends] = 0.25, 7.0, (1.0, 2.0)
    exporter = VTKExporter(part, [kinetic_energy, damage, ends], tmp_path / "dots", configuration="reference")
    rbs.Analysis([exporter]).run(steps=1, dt=0.5, progress=False)
    grid = pyvista.read(tmp_path / "dots_000001.vtu")
    mesh = meshio.read(tmp_path / "dots_000001.vtu")
    for held in (grid.field_data, mesh.field_data):
        assert np.ravel(held["kinetic_energy"]).tolist() == [7.0]
        assert np.ravel(held["ends"]).tolist() == [1.0, 2.0]
        assert np.ravel(held["TimeValue"]).tolist() == [0.5]
    assert list(grid.point_data) == ["damage"]


@pytest.mark.parametrize(
    ("size", "options", "radius"),
    [
        ((2.0,), {"area": 0.5}, 0.5),  # a segment as long as the cell
        ((2.0, 2.0), {"thickness": 0.1}, np.sqrt(1 / np.pi)),
        ((2.0, 2.0, 2.0), {}, (3 / (4 * np.pi)) ** (1 / 3)),
    ],
)
def test_spheres_disks_and_segments_of_the_radius_have_the_volume_of_the_body(tmp_path, size, options, radius):
    part = rbs.Part("dots", rbs.Box(size=size)).discretize(1.0, **options)
    exporter = VTKExporter(part, (), tmp_path / "dots", configuration="reference", radius=True)
    assert rbs.volume in exporter.reads
    rbs.Analysis([exporter]).run(steps=1, dt=0.5, progress=False)
    grid = pyvista.read(tmp_path / "dots_000001.vtu")
    np.testing.assert_allclose(grid["radius"], radius, rtol=1e-14)
    if len(size) == 3:
        spheres = grid.glyph(geom=pyvista.Sphere(radius=1.0), scale="radius", orient=False)
        assert np.ptp(spheres.points[:, 0]) == pytest.approx(1.0 + 2 * radius, rel=1e-2)


def test_a_field_with_the_name_of_the_radius_is_refused(tmp_path):
    own = Field("radius", "node", "scalar", "m", "R", "Made up for these tests.")
    part = rbs.Part("dots", rbs.Box(size=2.0)).discretize(1.0)
    with pytest.raises(BadInput, match="has the name of the radius of nodes: rename it"):
        VTKExporter(part, [own], tmp_path / "dots", radius=True)
    assert VTKExporter(part, [own], tmp_path / "dots").node_fields == [own]


def test_a_frame_takes_what_it_costs_to_write_its_bytes(tmp_path):
    """Points and fields of three numbers, two short numbers and a byte for the cell of each node, and a header."""
    part = rbs.Part("dots", rbs.Box(size=(100.0, 10.0))).discretize(1.0)
    part[displacement] = part[velocity] = 0.0
    rbs.Analysis([VTKExporter(part, [displacement, velocity], tmp_path / "dots")]).run(steps=1, dt=1.0, progress=False)
    size = (tmp_path / "dots_000001.vtu").stat().st_size
    assert 0 < size - len(part) * (3 * 3 * 8 + 4 + 4 + 1) < 2000
