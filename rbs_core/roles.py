"""What relations are for: a base class for each role."""

from __future__ import annotations

from rbs_core.relation import Relation


class Constitutive(Relation):
    """Forces from deformation."""

    role = "constitutive"


class Integrator(Relation):
    """Motion from forces."""

    role = "integrator"


class Boundary(Relation):
    """Prescribed motion and loads."""

    role = "boundary"


class Measure(Relation):
    """Quantities derived from the state, e.g. damage or energies: nothing moves because of them."""

    role = "measure"


class Exporter(Relation):
    """Writes files. The analysis checks that what it reads is finite before it writes."""

    role = "exporter"
    stays = True


class Statics(Relation):
    """Equilibria: each step of the clock is a step of the loads, found with relations that it owns."""

    role = "statics"
