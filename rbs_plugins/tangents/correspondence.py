"""The tangent of a correspondence model: one of its stress law, through the deformation gradients, and its control."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from rbs_core import Part
from rbs_plugins.fields import displacement
from rbs_plugins.loops import tensor_tangent_text
from rbs_plugins.loops.loop import Text
from rbs_plugins.loops.tensor_recipe import TensorRecipe
from rbs_plugins.loops.tensor_rows import TensorRowLoops
from rbs_plugins.tangents.base import Array, Tangent
from rbs_plugins.tangents.chain import Chain
from rbs_plugins.tangents.matrix import BlockMatrix
from rbs_plugins.tangents.pattern import Pattern
from rbs_plugins.tangents.springs import Springs


class CorrespondenceTangent(Tangent):
    """K = Γᵀ G Γ + springs, see `rbs_plugins.loops.tensor_tangent_text`.

    Args:
        part: connected part, bonds as list.
        recipe: of the force.
        loops: of the force.
        volumes: (n,) of the nodes, m^3.
        even: whether ∂P/∂F is symmetric, as that of a law with a potential.
        slope: derivative of the function that softens bonds, if there is one.
        now: gives time and dt, s.

    The matrix is −V_i times the rows of Hashim's Jacobian (2021, section 5.1), which makes it symmetric. Of what she
    prints, the inverse of the shape tensor is read for B, V_j stands inside of all sums, ∂P/∂F of appendix A is D:Q:N
    with F^-1 for F^-T in A.1.8 (here it comes from differences of P), and eq. 6.7 has tanh² n − 1.

    A node with a singular shape tensor has no row in Γ and no control: only the other ends of its bonds resist. With
    softening, the force of a bond fades by T_s while F counts it fully, so the matrix is not symmetric.
    """

    def __init__(
        self,
        part: Part,
        recipe: TensorRecipe,
        loops: TensorRowLoops,
        volumes: NDArray[np.float64],
        *,
        even: bool,
        slope: Callable[..., Any] | None,
        now: Callable[[], tuple[float, float]],
    ) -> None:
        offsets, neighbors = part.bonds.stored.as_rows()
        d, soft = part.dimension, recipe.softening is not None
        self.ends, self.symmetric = (part,), even and not soft
        self._loops, self._now, self._soft = loops, now, soft
        self._pattern = Pattern.of_families(offsets, neighbors)
        self._chain = Chain(self._pattern, d, d * d, gradient=True, apart=soft)
        self._place = np.zeros((len(part), d))
        self._springs = Springs(offsets, neighbors, self._place, apart=soft)
        n, m = len(part), len(neighbors)
        nodes = np.repeat(np.arange(n), np.diff(offsets))
        before = np.bincount(nodes[neighbors < nodes], minlength=n)
        pulls = np.zeros(m) if soft else self._springs.across
        given = {"cells": volumes, "starts": self._pattern.starts, "own": self._pattern.starts[:-1] + before,
                 "blocks": self._chain.blocks, "pulls": pulls}  # fmt: skip
        function = tensor_tangent_text.arms
        self._arms = loops.over(Text.of(function), function.__name__, intact=loops.holds, **given)
        moduli = tensor_tangent_text.text("moduli", _of_stress(recipe))
        weights = self._chain.weights.reshape(n, -1)
        self._moduli = loops.over(moduli, "moduli", cells=volumes, G=weights, even=int(even))
        if soft:
            fading = tensor_tangent_text.text("fading", replace(recipe, slope=slope).bare)
            self._loading = np.zeros(m, np.uint8)
            more = {"left": self._chain.left, "across": self._springs.across, "tilt": self._springs.left,
                    "loading": self._loading}  # fmt: skip
            self._fading = loops.over(fading, "fading", **given, **more)

    @cached_property
    def _matrix(self) -> BlockMatrix:
        return BlockMatrix(self._pattern.normal, self.ends[0].dimension)

    def update(self) -> None:
        time, dt = self._now()
        self._moduli.set(time=time, dt=dt)
        self._moduli()
        self._arms()
        if self._soft:
            self._fade(time, dt)
        self._chain.changed()

    def _fade(self, time: float, dt: float) -> None:
        """What softening changes."""
        part = self.ends[0]
        self._loops.evaluate(time, dt)
        now, before = self._loops.trial_stretch(time, dt), self._loops.largest_stretch
        self._loading[...] = False if now is None else now > before
        np.add(part.positions, part[displacement], out=self._place)
        self._fading.set(field_largest_stretch=before if now is None else now)
        self._fading()

    def matrix(self) -> csr_array[Any]:
        self._springs.add_to(self._matrix, afresh=True)
        self._chain.add_to(self._matrix)
        return self._matrix.matrix

    def multiply(self, v: Array, out: Array) -> None:
        self._chain.multiply(v, out)
        self._springs.multiply(v, out)

    def diagonal(self, out: Array) -> None:
        self._chain.diagonal(out)
        self._springs.diagonal(out)

    @property
    def nbytes(self) -> int:
        """Bytes of what the tangent keeps, without the matrix until it is asked for."""
        own = self._pattern.nbytes + self._chain.nbytes + self._springs.nbytes
        return own + (self._matrix.nbytes if "_matrix" in self.__dict__ else 0)


def _of_stress(recipe: TensorRecipe) -> TensorRecipe:
    """The recipe without what does not matter to stresses, so that models of one law share their loop."""
    return replace(
        recipe, criterion=None, criterion_arguments=(), potential=None, potential_arguments=(), softening=None,
        soft_arguments=(), breakable=False, late=False, keeps="", early=True,
    ).bare  # fmt: skip
