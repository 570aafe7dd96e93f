"""Random trees of coordinate systems of all kinds, and points that are away from their axes, centers and seams."""

from __future__ import annotations

import numpy as np

from rbs_core.space import CoordinateSystem, convert

KINDS = ("cartesian", "cylindrical", "spherical", "custom")
DOMAIN = np.random.default_rng(9).uniform(-4.0, 4.0, (40, 3))


def waves(points):
    """Each coordinate plus a wave of the next one: smooth, curved, and easy to undo from the last one backwards."""
    x, y, z = points.T
    return np.column_stack([x + 0.2 * np.sin(y), y + 0.2 * np.sin(z), z])


def no_waves(points):
    x, y, z = points.T
    y = y - 0.2 * np.sin(z)
    return np.column_stack([x - 0.2 * np.sin(y), y, z])


def slopes(points):
    result = np.tile(np.eye(3), (len(points), 1, 1))
    result[:, 1, 0] = 0.2 * np.cos(points[:, 1])
    result[:, 2, 1] = 0.2 * np.cos(points[:, 2])
    return result


def turned_axes(rng: np.random.Generator) -> np.ndarray:
    return np.linalg.qr(rng.normal(size=(3, 3)))[0]


def placed_below(parent: CoordinateSystem, cloud: np.ndarray, kind: str, rng: np.random.Generator, name: str):
    """A system whose axis, center and seam are several times as far from the cloud as the cloud is large."""
    axes, middle = turned_axes(rng), cloud.mean(axis=0)
    away = 1.0 + 3.0 * np.linalg.norm(cloud - middle, axis=1).max()
    angle, polar = rng.uniform(-1.5, 1.5), rng.uniform(1.0, 2.0)
    if kind == "cylindrical":
        local = np.array([away * np.cos(angle), away * np.sin(angle), rng.uniform(-1.0, 1.0)])
        return parent.cylindrical(name, middle - local @ axes, axes)
    if kind == "spherical":
        level = away * np.sin(polar)
        local = np.array([level * np.cos(angle), level * np.sin(angle), away * np.cos(polar)])
        return parent.spherical(name, middle - local @ axes, axes)
    axes = axes * rng.uniform(0.7, 1.4, (3, 1)) + rng.uniform(-0.1, 0.1, (3, 3))
    if kind == "custom":
        return parent.custom(name, waves, no_waves, middle, axes, samples=DOMAIN, jacobian=slopes)
    return parent.child(name, middle - rng.uniform(-1.0, 1.0, 3), axes)


def branch(parent: CoordinateSystem, cloud: np.ndarray, kinds: list[str], rng: np.random.Generator, name: str):
    """A line of systems of these kinds below a parent that holds a cloud of points, and the cloud in the last one."""
    system = parent
    for level, kind in enumerate(kinds):
        below = placed_below(system, cloud, kind, rng, f"{name}{level}")
        system, cloud = below, convert(cloud, system, below)
    return system, cloud
