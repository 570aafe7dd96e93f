"""Numbers made of node fields: sums, means and extremes over a region, for tables.

Sums are pairwise, in double precision and in the order of the nodes, on one thread: they do not depend on the number of
threads, and round-off does not grow with the number of nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core import BadInput, Field, Part
from rbs_core.errors import nearest
from rbs_plugins.exporters.names import field_of

AXES = "xyz"
MAGNITUDE = "magnitude"
Values = NDArray[np.float64]
Component = str | int | tuple[int, int] | None


def total(
    field: Field, where: Any = None, *, component: Component = None, weights: Field | None = None,
    name: str | None = None,
) -> Reduction:  # fmt: skip
    """Sum over nodes, for a table: Σ q, or Σ w q with weights.

    Args:
        field: node field.
        where: region of nodes: a geometry, a mask, indices, a function of the reference positions, a layer, or
            the name of a node set of the part; if not given, all nodes but those of fictitious layers.
        component: "x", "y", "z" or a number for vectors, two of them for tensors ("xy"), or "magnitude"; a column for
            each component if not given.
        weights: scalar node field, e.g. `volume`: the force on a region is
            `total(force_density, region, weights=volume)`.
        name: of the column; made of the other arguments if not given.

    Raises:
        BadInput: if these are no node fields, with the nearest names; where the table is made, if the component, the
            region or the node set does not exist.
    """
    return Reduction("total", field, where, component, weights, name)


def mean(
    field: Field, where: Any = None, *, component: Component = None, weights: Field | None = None,
    name: str | None = None,
) -> Reduction:  # fmt: skip
    """Mean over nodes, for a table: Σ q / n, or Σ w q / Σ w with weights (`volume` for a mean over the body).

    Args and errors as for `total`.
    """
    return Reduction("mean", field, where, component, weights, name)


def largest(field: Field, where: Any = None, *, component: Component = None, name: str | None = None) -> Reduction:
    """Largest value among nodes, for a table; args and errors as for `total`."""
    return Reduction("largest", field, where, component, None, name)


def smallest(field: Field, where: Any = None, *, component: Component = None, name: str | None = None) -> Reduction:
    """Smallest value among nodes, for a table; args and errors as for `total`."""
    return Reduction("smallest", field, where, component, None, name)


class Reduction:
    """What `total`, `mean`, `largest` and `smallest` return: what to compute, of a part that is not known yet."""

    def __init__(
        self, kind: str, field: Field, where: Any, component: Component, weights: Field | None, name: str | None
    ) -> None:
        why = "only those can be reduced to a number"
        self.kind, self.where, self.component, self.name = kind, where, component, name
        self.field = field_of(kind, field, ("node",), why)
        self.weights = None if weights is None else field_of(f"{kind}, weights", weights, ("node",), why)
        if self.weights is not None and self.weights.shape != "scalar":
            raise BadInput(f"{kind}: weights={weights!r} must be a scalar, such as the volume")

    @property
    def reads(self) -> tuple[Field, ...]:
        """The fields that it looks at."""
        return (self.field,) if self.weights is None else (self.field, self.weights)

    @property
    def unit(self) -> str:
        """Of the number."""
        if self.kind != "total" or self.weights is None:
            return self.field.unit
        return _product(self.field.unit, self.weights.unit)

    def __repr__(self) -> str:
        where = f"<array {self.where.shape}>" if isinstance(self.where, np.ndarray) else repr(self.where)
        region = "" if self.where is None else f", {getattr(self.where, '__name__', where)}"
        given = {"component": self.component, "name": self.name}
        options = "".join(f", {name}={value!r}" for name, value in given.items() if value is not None)
        weights = "" if self.weights is None else f", weights={self.weights.name}"
        return f"{self.kind}({self.field.name}{region}{options}{weights})"


class Reduced:
    """A reduction of the nodes of a part: one column of a table, or one for each component.

    Args:
        owner: who wants it, for messages.
        reduction: what to compute.
        part: whose nodes.

    Attributes:
        names: of the columns.
        unit: of all of them.

    Raises:
        BadInput: if the component, the region or the node set does not exist.
    """

    def __init__(self, owner: str, reduction: Reduction, part: Part) -> None:
        self._reduction, self.unit = reduction, reduction.unit
        self._owner = f"{owner}: {reduction!r}"
        everywhere = part.body if part.extended else None
        self._nodes = everywhere if reduction.where is None else nodes_of(self._owner, part, reduction.where)
        components = _components(self._owner, reduction.field, reduction.component, part.dimension)
        self._entries = [entry for _, entry in components]
        region = f"_{reduction.where}" if isinstance(reduction.where, str) else ""
        self.names = [f"{reduction.kind}_{reduction.field.name}{suffix}{region}" for suffix, _ in components]
        if reduction.name is not None:
            suffixes = [""] if len(components) == 1 else [suffix for suffix, _ in components]
            self.names = [f"{reduction.name}{suffix}" for suffix in suffixes]

    def __call__(self, fetch: Callable[[Field], NDArray[Any]]) -> list[float]:
        """The numbers now; `fetch` gives the array of a field."""
        reduction = self._reduction
        values = self._chosen(fetch(reduction.field))
        columns = [np.ascontiguousarray(entry(values), np.float64) for entry in self._entries]
        if reduction.kind in ("largest", "smallest"):
            return [float(column.max() if reduction.kind == "largest" else column.min()) for column in columns]
        shares = None if reduction.weights is None else self._chosen(fetch(reduction.weights)).astype(np.float64)
        # not by a product of matrices, which sums as the threads of its library like
        sums = [float(column.sum() if shares is None else (shares * column).sum()) for column in columns]
        if reduction.kind == "total":
            return sums
        whole = len(values) if shares is None else float(shares.sum())
        if whole == 0:
            raise BadInput(f"{self._owner}: the weights add up to nothing, so there is no mean: choose others")
        return [value / whole for value in sums]

    def _chosen(self, array: NDArray[Any]) -> NDArray[Any]:
        return array if self._nodes is None else array[self._nodes]


def nodes_of(owner: str, part: Part, where: Any) -> NDArray[np.int64] | None:
    """Indices of the nodes of a region, None for all.

    Args:
        owner: who asks, for messages.
        part: whose nodes.
        where: as `part.where` takes it, or the name of a node set of the part; None for all.

    Raises:
        BadInput: if there is no such node set, with the nearest names, or no node in the region.
    """
    if where is None:
        return None
    if isinstance(where, str) and where not in part.node_sets:
        raise BadInput(f"{owner}: part '{part.name}' has no node set {where!r}: {nearest(where, part.node_sets)}")
    nodes = part.where(where)
    if not len(nodes):
        raise BadInput(f"{owner}: no node of part '{part.name}' lies in {where!r}: check the region or the spacing")
    return nodes


def _components(
    owner: str, field: Field, component: Component, dimension: int
) -> list[tuple[str, Callable[[NDArray[Any]], NDArray[Any]]]]:
    """End of the name of each column, and what takes its values from the array (n, ...) of a field.

    Raises:
        BadInput: if the field has no such component.
    """
    entries = list(np.ndindex(*field.entry(dimension)))
    letters = ["".join(AXES[axis] for axis in entry) for entry in entries]
    if component == MAGNITUDE and field.shape != "scalar":
        return [(f"_{MAGNITUDE}", _magnitude)]
    if component is not None:
        wanted: Any = component if isinstance(component, str | tuple) else (component,)
        found = [k for k in range(len(entries)) if field.shape != "scalar" and wanted in (letters[k], entries[k])]
        if not found:
            known = f"one of {', '.join(letters)}, {MAGNITUDE}" if field.shape != "scalar" else "left out for a scalar"
            raise BadInput(f"{owner}: component={component!r} must be {known}")
        entries, letters = [entries[found[0]]], [letters[found[0]]]
    return [(f"_{letter}" if letter else "", _entry(entry)) for letter, entry in zip(letters, entries, strict=True)]


def _entry(entry: tuple[int, ...]) -> Callable[[NDArray[Any]], NDArray[Any]]:
    """Takes one component of every node."""
    index: Any = (slice(None), *entry)
    return lambda array: array[index]


def _magnitude(array: NDArray[Any]) -> NDArray[Any]:
    """Takes the root of the sum of the squares of the components of every node."""
    return np.asarray(np.sqrt(np.square(array, dtype=np.float64).sum(axis=tuple(range(1, array.ndim)))))


def _product(unit: str, other: str) -> str:
    """Unit of a product: N/m^3 times m^3 is N."""
    if unit.endswith(f"/{other}"):
        return unit.removesuffix(f"/{other}")
    return {"1": other}.get(unit, unit if other == "1" else f"{unit} {other}")
