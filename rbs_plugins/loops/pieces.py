"""Small pieces of source that the texts of all loops are made of."""

from __future__ import annotations

from rbs_plugins.loops.arguments import Argument
from rbs_plugins.loops.source import STRICT

# Nodes and weights of Gauss-Legendre with 5 points on [0, 1], for potentials that nobody has given.
_GAUSS = ((0.04691007703066802, 0.11846344252809454), (0.23076534494715845, 0.23931433524968324),
          (0.5, 0.28444444444444444), (0.7692346550528415, 0.23931433524968324),
          (0.9530899229693319, 0.11846344252809454))  # fmt: skip
_PANELS = 8


def indented(lines: list[str], by: int = 1) -> list[str]:
    """Lines moved to the right."""
    return ["    " * by + line for line in lines]


def strict(name: str, parameters: str, *lines: str) -> str:
    """A small function that is inlined and not reordered."""
    return "\n".join([STRICT, f"def {name}({parameters}):", *indented(list(lines))])


FAILS = strict("fails", "answer", "return answer != 0")


def quadrature(law_arguments: tuple[Argument, ...]) -> str:
    """Potential = |ξ| ∫ law d(stretch) from 0 to the stretch, by Gauss-Legendre on panels."""
    fixed = [f"a_{a.name}" for a in law_arguments if a.kind != "kinematic"]
    names = {"stretch": "x", "length": "(1.0 + x) * size", "extension": "x * size", "reference_length": "size"}
    values = [names[a.name] if a.kind == "kinematic" else f"a_{a.name}" for a in law_arguments]
    terms = [
        line
        for point, weight in _GAUSS
        for line in (
            f"    x = stretch * (panel + {point}) / {_PANELS}",
            f"    total += {weight} * law({', '.join(values)})",
        )
    ]
    return strict("potential", ", ".join(["stretch", "size", *fixed]), "total = 0.0", f"for panel in range({_PANELS}):",
                  *terms, f"return total * stretch * size / {_PANELS}")  # fmt: skip
