"""Tangents: derivatives of forces by displacements, as sparse matrices and as products without one, for statics.

Nodes couple with their families, or, through sums at the nodes between (the dilatation, the deformation gradient),
with the families of those: `pattern` says who with whom, `matrix` holds the blocks, `springs` are bonds by themselves,
`chain` is what goes through the sums. Compiled throughout; a row of a matrix, and an entry of a product, belongs to one
thread, so nothing depends on their number.
"""

from __future__ import annotations

from rbs_plugins.tangents.base import Tangent
from rbs_plugins.tangents.chain import Chain
from rbs_plugins.tangents.matrix import BlockMatrix
from rbs_plugins.tangents.pattern import Pattern

__all__ = ["BlockMatrix", "Chain", "Pattern", "Tangent"]
