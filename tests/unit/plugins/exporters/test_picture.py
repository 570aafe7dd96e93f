"""Pictures: there, not blank, of the right size, and different where the fields differ."""

from __future__ import annotations

import logging

import numpy as np
import pytest
import pyvista

import rbs_core as rbs
from rbs_core import BadInput
from rbs_plugins import PictureExporter
from rbs_plugins.exporters.frames import axis_of, three
from rbs_plugins.fields import damage, displacement, kinetic_energy


def plate(system=None):
    part = rbs.Part("plate", rbs.Box(size=(2.0, 1.0)), system=system).discretize(0.05).connect(0.1)
    part[displacement] = lambda X: 0.1 * X
    part[damage] = lambda X: X[:, 0] > 0
    return part


def pixels(path):
    """(height, width, 3) values from 0 to 255."""
    image = pyvista.read(path)
    width, height, _ = image.dimensions
    return np.asarray(image.active_scalars).reshape(height, width, -1)[:, :, :3].astype(float)


def draw(part, field, path, **options):
    exporter = PictureExporter(part, field, path, size=(300, 200), **options)
    rbs.Analysis([exporter]).run(steps=1, dt=1.0, progress=False)
    if not exporter._able:
        pytest.skip("no picture can be drawn on this machine")
    return pixels(path.with_name(f"{path.name}_000001.png"))


def test_picture_shows_something(tmp_path):
    image = draw(plate(), damage, tmp_path / "damage")
    assert image.shape == (200, 300, 3)
    assert image.std() > 20  # a blank picture has 0
    assert 50 < image.mean() < 250
    colors = {tuple(c) for c in image.reshape(-1, 3)}
    assert (255.0, 255.0, 255.0) in colors  # background
    dark, bright = np.array([68, 1, 84]), np.array([253, 231, 37])  # both ends of viridis
    for end in (dark, bright):
        near = np.abs(image - end).max(axis=2) <= 3
        assert near.mean() > 0.05, f"{end} should fill about half of the plate"


def test_pictures_of_other_fields_differ(tmp_path):
    part = plate()
    images = [
        draw(part, damage, tmp_path / "a"),
        draw(part, displacement, tmp_path / "b"),
        draw(part, displacement, tmp_path / "c", component="x"),
        draw(part, displacement, tmp_path / "d", component=1),
        draw(part, damage, tmp_path / "e", limits=(0.0, 10.0)),
        draw(part, damage, tmp_path / "f", colors="gray"),
    ]
    for i, one in enumerate(images):
        for other in images[:i]:
            assert np.abs(one - other).mean() > 0.5


@pytest.mark.parametrize("component", ["z", 2, -1, "w", "xy", ""])
def test_component_must_exist(component, tmp_path):
    with pytest.raises(BadInput, match="has no component"):
        PictureExporter(plate(), displacement, tmp_path / "a", component=component)


def test_component_of_a_scalar(tmp_path):
    with pytest.raises(BadInput, match="has no component 'x'"):
        PictureExporter(plate(), damage, tmp_path / "a", component="x")


def test_only_node_fields(tmp_path):
    with pytest.raises(BadInput, match="no node field"):
        PictureExporter(plate(), kinetic_energy, tmp_path / "a")


@pytest.mark.parametrize("scale", [1.0, 5.0])
def test_scaled_displacements_are_those_of_the_part_wherever_it_lies(scale):
    """Ten times the stretch of a plate that stands upright, far away."""
    upright = rbs.world.child("upright", origin=(10.0, 0.0, 0.0), axes=[(0, 0, 1), (0, 1, 0), (-1, 0, 0)])
    part = plate(upright)
    exporter = PictureExporter(part, damage, "unused", scale=scale)
    rbs.Analysis([exporter]).prepare()
    X = part.positions * (1 + 0.1 * scale)
    np.testing.assert_allclose(exporter.positions(scale), np.c_[0 * X[:, 0] + 10.0, X[:, 1], X[:, 0]], atol=1e-14)


def test_run_goes_on_where_no_picture_can_be_drawn(tmp_path, monkeypatch, caplog):
    def refuse(self, clock):
        raise RuntimeError("no graphics")

    monkeypatch.setattr(PictureExporter, "_draw", refuse)
    with caplog.at_level(logging.WARNING, logger="rbs"):
        report = rbs.Analysis([PictureExporter(plate(), damage, tmp_path / "a")]).run(steps=3, dt=1.0, progress=False)
    assert report.steps == 3
    assert [record.message for record in caplog.records if "cannot draw" in record.message] == [
        "PictureExporter 'plate' a cannot draw (no graphics): the run goes on without pictures"
    ]


def test_helpers_of_frames():
    assert [axis_of(name) for name in ("x", "z", "u", 1, None)] == [0, 2, -1, 1, None]
    assert three(np.array([1.0, 2.0])).tolist() == [1.0, 2.0]
    assert three(np.array([[1.0, 2.0]])).tolist() == [[1.0, 2.0, 0.0]]
    assert three(np.array([[[1.0, 2.0], [3.0, 4.0]]])).tolist() == [[1.0, 2.0, 0.0, 3.0, 4.0, 0.0, 0.0, 0.0, 0.0]]
