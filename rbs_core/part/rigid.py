"""Which coordinate systems a part may live in: those in which a length is a length."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import BadInput
from rbs_core.space import Cartesian, CoordinateSystem

# Part by which a length may change on its way from a system to the root: as for the horizon, far above round-off.
RIGIDITY = 1e-9


def rigid(system: CoordinateSystem, part: str) -> CoordinateSystem:
    """The system, refused unless lengths in it are those in the root of its tree."""
    if not isinstance(system, CoordinateSystem):
        raise BadInput(f"Part({part!r}): system = {system!r} is no CoordinateSystem; give world or a system below it")
    axes, culprit = np.eye(3), None
    below: CoordinateSystem | None = system
    while below is not None and below.mapping is not None:
        mapping = below.mapping
        if not isinstance(mapping, Cartesian):
            raise BadInput(
                f"Part({part!r}): system {below.path!r} is not Cartesian ({mapping!r}), so that bond lengths would not "
                "be lengths: put the part into a Cartesian system and shape its geometry with geometry.placed(system)"
            )
        axes = axes @ mapping.axes
        if culprit is None and not _orthonormal(mapping.axes):
            culprit = below
        below = below.parent
    if culprit is not None and not _orthonormal(axes):
        raise BadInput(
            f"Part({part!r}): system {culprit.path!r} has axes that are not of length 1 at right angles "
            f"({culprit!r}), so that bond lengths would not be lengths: give it such axes, or stretch the geometry "
            "instead with geometry.placed(system)"
        )
    return system


def _orthonormal(axes: NDArray[np.float64]) -> bool:
    return bool(np.abs(axes @ axes.T - np.eye(3)).max() <= RIGIDITY)
