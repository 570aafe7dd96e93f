"""Bodies whose bonds are stored as list and as lattice, and how close what comes out of both must be."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import rbs_core as rbs
from rbs_plugins import Damage, FractureDissipation, PairwiseForce, StrainEnergy
from rbs_plugins.fields import (
    damage,
    density,
    displacement,
    dissipation_density,
    force_density,
    strain_energy_density,
    volume,
)

STORAGES = ("list", "lattice")
SPACING = 0.5
ROUGH = 1e-2  # displacements in spacings: the size of the stretches

warmth = rbs.Field("warmth", "node", "scalar", "K", "T", "Made up for these tests.")
grade = rbs.Field("grade", "bond", "scalar", "1", "g", "Made up for these tests.")


def body(
    storage: str,
    shape: Sequence[int],
    *,
    ratio: float = 3.015,
    hole: bool = False,
    uneven: bool = False,
    name: str = "body",
) -> rbs.Part:
    """A grid away from the origin, with the longer bonds through its middle broken, and displaced at random."""
    center = np.array([1.5, -0.75, 2.25])[: len(shape)]
    geometry = rbs.Box(size=[SPACING * n for n in shape], center=center)
    if hole:
        geometry = geometry - rbs.Ball(1.6 * SPACING, center + 0.3 * SPACING)
    part = rbs.Part(name, geometry).discretize(SPACING).connect(ratio * SPACING, storage=storage)
    x = part.positions
    part[density] = 1000.0 + 10 * np.sin(x[:, 0])
    part[warmth] = np.cos(3 * x.sum(axis=1))
    if uneven:
        part[volume] = part[volume] * (1.0 + 0.3 * np.sin(7 * x[:, 0]))
    part.bonds.cut(
        lambda starts, ends: (
            ((starts[:, 0] > center[0]) != (ends[:, 0] > center[0]))
            & (np.linalg.norm(ends - starts, axis=1) > 1.5 * SPACING)
        )
    )
    part[displacement] = ROUGH * SPACING * np.random.default_rng(3).uniform(-1.0, 1.0, x.shape)
    return part


def history(part: rbs.Part, make: Callable[[rbs.Part], list[PairwiseForce]]) -> dict[str, np.ndarray]:
    """What comes out of the forces while a displacement grows, turns round and comes back."""
    forces = make(part)
    breaking = [force for force in forces if force.updates]
    measures: list[Any] = [StrainEnergy(part, forces), Damage(part)]
    fields = [force_density, strain_energy_density, damage]
    if len(forces) == 1 and breaking:
        measures.append(FractureDissipation(part))
        fields.append(dissipation_density)
    start, found = part[displacement].copy(), {}
    analysis = rbs.Analysis([*forces, *measures])
    for step, share in enumerate((0.5, 1.0, -1.2, 0.7), 1):
        part[displacement] = share * start
        analysis.run(steps=step, dt=0.1, force_dt=True, progress=False)
        found.update({f"{field.name} {step}": part[field].copy() for field in fields})
        found[f"intact {step}"] = part.bonds.intact.copy()
    found["squared frequency"] = sum(force.squared_frequency() for force in forces)
    return found


def assert_close(one: dict[str, np.ndarray], two: dict[str, np.ndarray], part: rbs.Part) -> None:
    """Equal states of bonds, and numbers that differ by no more than the positions of a list round.

    A list takes stretches from X + u, which rounds by eps |X| / 2 in each component at either end, so that a stretch
    is off by a few eps |X| / spacing. That is compared with stretches of the size ROUGH; the sums of a family are
    smaller than the sums of the sizes of their terms by up to a factor of ten.
    """
    agree = 40 * np.finfo(float).eps * np.abs(part.positions).max() / SPACING / ROUGH
    assert one.keys() == two.keys()
    for name, values in one.items():
        if values.dtype == bool:
            assert np.array_equal(values, two[name]), name
            continue
        np.testing.assert_allclose(two[name], values, rtol=0, atol=agree * np.abs(values).max(), err_msg=name)
