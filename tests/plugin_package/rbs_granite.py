"""Granite for RBS: bonds that soften before they break."""

import rbs_core as rbs
from rbs_plugins import BondBased, CriticalStretch


def softening(stretch, c, s_yield, s_break):
    """Straight up to s_yield, then straight down to nothing at s_break."""
    if stretch < s_yield:
        return c * stretch
    return c * s_yield * (s_break - stretch) / (s_break - s_yield)


def softening_potential(stretch, reference_length, c, s_yield, s_break):
    """Area under it: the triangle up to s_yield, and from there the trapezoid up to the stretch."""
    if stretch < s_yield:
        return 0.5 * c * stretch * stretch * reference_length
    force = c * s_yield * (s_break - stretch) / (s_break - s_yield)
    area = 0.5 * c * s_yield * s_yield + 0.5 * (c * s_yield + force) * (stretch - s_yield)
    return area * reference_length


class Granite(BondBased):
    """Bond-based rock with linear softening (unloads along the same curve).

    Args:
        part: connected part.
        E: Young's modulus, Pa.
        s_yield: stretch at the peak of the force.
        s_break: stretch at which the force is gone and the bond breaks.
        **options: see BondBased.
    """

    law = staticmethod(softening)
    potential = staticmethod(softening_potential)
    example = {"E": 50e9, "s_yield": 1e-3, "s_break": 8e-3}

    def __init__(self, part, E, s_yield, s_break, **options):
        super().__init__(part, E, CriticalStretch(s_break), s_yield=s_yield, s_break=s_break, **options)


@rbs.hookimpl
def rbs_relations():
    """What this package offers."""
    return [Granite]
