"""What measures on families have in common: the bonds that they read, and the deformation gradient of a family."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Field, Part, Trigger, always
from rbs_core.relation import Fields, Key
from rbs_plugins.constitutive.bonded import BondRelation, precision_of
from rbs_plugins.constitutive.corrections import set_partial_volume
from rbs_plugins.constitutive.correspondence import Correspondence
from rbs_plugins.constitutive.influence import Influence, set_influence
from rbs_plugins.constitutive.pairwise import PairwiseForce
from rbs_plugins.fields import displacement, intact, reference_position, volume, volume_fraction
from rbs_plugins.loops.arguments import Argument, fields, resolve
from rbs_plugins.loops.recipe import Recipe
from rbs_plugins.loops.tensor_recipe import SINGULAR


def share(influence):
    """How much a bond counts in the sums of its family."""
    return influence


class FamilyMeasure(BondRelation):
    """A measure that sums over the families of a part.

    Args:
        part: connected part.
        influence: ω of the sums for the deformation gradient, as of Dilatation.
        partial_volume: as of PairwiseForce; None (default) for the volume fractions that the bonds have, if any.
        when: trigger.

    Raises:
        BadInput: on anything but a connected part, an unknown partial volume or an influence that is not possible.
    """

    role = "measure"
    storages = ("list", "lattice")

    def __init__(
        self,
        part: Part,
        influence: Influence | str = "constant",
        *,
        partial_volume: str | None = None,
        when: Trigger = always,
    ) -> None:
        if not isinstance(part, Part):
            raise BadInput(f"{type(self).__name__}: the first argument must be a Part, got {part!r}")
        super().__init__(part, when=when)
        self._given_fraction = partial_volume is not None and set_partial_volume(part, partial_volume)
        self._as_found = partial_volume is None
        self.weights: tuple[Argument, ...] = tuple(resolve(share, part, set_influence(part, influence, self.label)))

    @property
    def fraction(self) -> bool:
        """Whether neighbors count with a volume fraction."""
        return volume_fraction in self.part if self._as_found else self._given_fraction

    @property
    def of_family(self) -> Fields:
        """What the deformation gradient needs."""
        more = [*([volume_fraction] if self.fraction else []), *([intact] if self.may_have_broken else [])]
        return (displacement, reference_position, volume, *more, *fields(self.weights))

    def of_forces(self, forces: Sequence[PairwiseForce]) -> Fields:
        """What forces read, and the state of their bonds."""
        looked_at: list[Field | Key] = [key for force in forces for key in (*force.reads, *force.updates)]
        return tuple(key[1] if isinstance(key, tuple) else key for key in looked_at)

    def items(self) -> int:
        return len(self.part.bonds)


def checked_forces(label: str, part: Part, forces: PairwiseForce | Sequence[PairwiseForce]) -> list[PairwiseForce]:
    """Forces as a list.

    Raises:
        BadInput: if there is none, one is no pairwise force, or its bonds are not those of the part.
    """
    every = [forces] if isinstance(forces, PairwiseForce) else list(forces)
    if not every:
        raise BadInput(f"{label}: no force is given: list the constitutive relations whose bonds carry the stress")
    for force in every:
        if isinstance(force, Correspondence):
            raise BadInput(
                f"{label}: {force.label} has no scalar force state, and offers its own stress: list the field `stress` "
                "in an exporter, and leave this measure out"
            )
        if not isinstance(force, PairwiseForce):
            raise BadInput(f"{label}: {force!r} has no force state along its bonds: list relations such as BondBased")
        if force.host is not part:
            raise BadInput(
                f"{label}: {force.label} acts on other bonds than those of '{part.name}': list forces of this part; "
                "bonds between parts have no common reference configuration, in which a stress could be given"
            )
    return every


class DisplacementGradient:
    """H = F − I of every family: H = [Σ ω η⊗ξ β V] K⁻¹, K = Σ ω ξ⊗ξ β V over the intact bonds.

    F is that of Silling et al. (2007). With η = Y − ξ in place of Y the sums are the same in exact numbers, and keep
    all digits of a small strain. Exact for affine displacements.

    Where det K is not above SINGULAR (tr K / d)^d (bonds in nearly one plane, or along one line) K is not inverted, by
    the same rule as in Correspondence: H is zero there, and the node is counted.

    Args:
        of: the measure; it has been attached.

    Attributes:
        values: (n, d, d), dimensionless, as `find` has found them.
        singular: how many nodes of the body have a singular shape tensor.
    """

    def __init__(self, of: FamilyMeasure) -> None:
        part, self._of = of.part, of
        shape, real = (len(part), part.dimension, part.dimension), precision_of(part)
        self.values, self.singular = np.zeros(shape), 0
        self._moved, self._shape = np.zeros(shape, real), np.zeros(shape, real)
        self._inverse: NDArray[np.float64] | None = None
        recipe = Recipe(
            law=share, law_arguments=of.weights, sums="tensor", intact=of.may_have_broken, fraction=of.fraction,
            uniform=of.uniform(volume) is not None, scales=("influence",), **of.processor(),
        )  # fmt: skip
        # with the reference positions as displacement η is ξ
        places = np.ascontiguousarray(part.positions - part.positions.mean(axis=0), real)
        self._loops = of.make_loops(recipe, {"out": [self._moved]}, False)
        self._shapes = of.make_loops(recipe, {"out": [self._shape]}, False, {displacement: [places]})

    def find(self, time: float = 0.0, dt: float = 0.0) -> NDArray[np.float64]:
        """Sums anew, over the bonds that hold now."""
        if self._inverse is None or self._of.may_have_broken:
            self._sum(self._shapes, self._shape, time, dt)
            self._inverse, regular = inverses(self._shape.astype(np.float64))
            self.singular = int(np.count_nonzero(~regular[self._of.part.body]))
        self._sum(self._loops, self._moved, time, dt)
        np.matmul(self._moved, self._inverse, out=self.values)
        return self.values

    def _sum(self, loops: Any, out: NDArray[Any], time: float, dt: float) -> None:
        out.fill(0.0)
        loops.begin()
        loops.add(time, dt)

    @property
    def nbytes(self) -> int:
        """Bytes held."""
        arrays = (self.values, self._moved, self._shape, self._inverse)
        held = sum(array.nbytes for array in arrays if array is not None)
        return held + self._loops.nbytes + self._shapes.nbytes


def inverses(tensors: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Inverses (n, d, d) of symmetric positive tensors, zero for those that are singular; which ones are regular."""
    d = tensors.shape[1]
    size = np.trace(tensors, axis1=1, axis2=2) / d
    # scaled: entries in m^5 are small, and products of them underflow
    scaled = tensors / np.where(size > 0, size, 1.0)[:, None, None]
    regular = (size > 0) & (np.linalg.det(scaled) > SINGULAR[d])
    found = np.zeros_like(tensors)
    found[regular] = np.linalg.inv(scaled[regular]) / size[regular][:, None, None]
    return found, regular
