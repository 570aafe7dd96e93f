"""What can be wrong with a scene: every message says what is wrong, where, and the cure."""

from __future__ import annotations

import difflib
from collections import abc


class RBSError(Exception):
    """Base class of the errors of this package: `except RBSError` catches them all and nothing else."""


class BadInput(RBSError, ValueError):
    """A number, array or option that cannot be used."""


class MissingField(RBSError, LookupError):
    """A relation reads a field that nobody provides."""


class UndeclaredField(RBSError, LookupError):
    """A relation fetches a field that is not in its contract."""


class DishonestRelation(RBSError, RuntimeError):
    """A relation does something else to a field than its contract says."""


class FieldClash(RBSError, ValueError):
    """Two fields, or two relations, claim the same thing in ways that contradict each other."""


class BadLaw(RBSError, ValueError):
    """A law or criterion has an argument that nobody knows, or cannot be compiled."""


class BadCheckpoint(RBSError, ValueError):
    """A checkpoint that belongs to another scene, or is damaged."""


class UnstableStep(RBSError, ValueError):
    """A time step above the largest stable one."""


class NotFinite(RBSError, ArithmeticError):
    """NaN or infinity appeared during a run."""


class NotConverged(RBSError, ArithmeticError):
    """A static solver found no equilibrium; `history` tells what it tried, as it has recorded it."""

    history: abc.Sequence[object] = ()


def nearest(name: str, known: abc.Iterable[str]) -> str:
    """The known names that are most like a misspelt one, or all of them if none is like it, for messages."""
    known = sorted(known)
    close = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
    if close:
        return f"the nearest names are {', '.join(close)}"
    return f"there are {', '.join(known)}" if known else "there are none"
