"""read_run: what HDF5Exporter has written, as arrays that are read from the file when somebody looks at them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rbs_core import BadInput, Field
from rbs_core.errors import nearest
from rbs_plugins.exporters.hdf5 import FORMAT, VERSION

AXES = ("x", "y", "z")


def read_run(path: str | Path) -> Run:
    """What a file of HDF5Exporter holds; nothing large is read before it is asked for.

    The file is open only while something is read from it, so that a run can go on writing; what it writes later needs
    another `read_run`.

    Args:
        path: the file.

    Raises:
        BadInput: if it is not there, or is no such file.
    """
    import h5py

    path = Path(path)
    if not path.exists():
        beside = [each.name for each in path.parent.glob("*.h5")] if path.parent.is_dir() else []
        raise BadInput(f"there is no file {path}: {nearest(path.name, beside)} in {path.parent}")
    try:
        with h5py.File(path, "r", locking=False) as file:
            found = (file.attrs.get("format"), file.attrs.get("version"))
            if found == (FORMAT, VERSION):
                return Run(path, file)
    except (OSError, KeyError) as error:
        raise BadInput(f"{path} is damaged or no HDF5 file ({error}): run the scene again") from None
    raise BadInput(f"{path} is no run of format {VERSION} that HDF5Exporter has written, but {found}")


class Run:
    """A run: `run["plate"]["displacement"][-1]` is the last displacement of the part 'plate'.

    Args:
        path: the file.
        file: the same, open.

    Attributes:
        times: (frames,) s.
        steps: (frames,) numbers of the steps.
        parts: names of the parts.
    """

    def __init__(self, path: Path, file: Any) -> None:
        count = int(file.attrs["frames"])
        self.path = path
        self.times: NDArray[np.float64] = file["time"][:count]
        self.steps: NDArray[np.int64] = file["step"][:count]
        self._parts = {name: RecordedPart(self, name, group) for name, group in file["parts"].items()}
        self.parts = tuple(self._parts)

    def __len__(self) -> int:
        return len(self.times)

    def __iter__(self) -> Iterator[str]:
        return iter(self.parts)

    def __getitem__(self, name: str) -> RecordedPart:
        if name not in self._parts:
            raise BadInput(f"{self.path} holds no part {name!r}: {nearest(str(name), self.parts)}")
        return self._parts[name]

    def at(self, time: float) -> int:
        """Index of the frame whose time is nearest, s."""
        return int(np.abs(self.times - time).argmin())

    def read(self, place: str) -> NDArray[Any]:
        """A whole array of the file, by its place in it."""
        import h5py

        with h5py.File(self.path, "r", locking=False) as file:
            return np.asarray(file[place][...])

    def __repr__(self) -> str:
        times = f"{self.times[0]:g} to {self.times[-1]:g} s" if len(self) else "none"
        return f"<Run {self.path.name}, {len(self)} frames, {times}, parts {', '.join(self.parts)}>"


class RecordedPart:
    """A part of a run: `part["damage"]`, or `part[damage]` with the field itself.

    Attributes:
        name: of the part.
        dimension: 1, 2 or 3.
        fields: names of its fields.
    """

    def __init__(self, run: Run, name: str, group: Any) -> None:
        self.run, self.name, self.dimension = run, name, int(group.attrs["dimension"])
        self._nodes = len(group["position"])
        self._fields = {field: RecordedField(run, data) for field, data in group["fields"].items()}
        self.fields = tuple(self._fields)

    def __len__(self) -> int:
        return self._nodes

    def __iter__(self) -> Iterator[str]:
        return iter(self.fields)

    def __contains__(self, field: str | Field) -> bool:
        return getattr(field, "name", field) in self._fields

    def __getitem__(self, field: str | Field) -> RecordedField:
        name = getattr(field, "name", field)
        if name not in self._fields:
            raise BadInput(f"part '{self.name}' of {self.run.path} has no field {name!r}: {nearest(str(name), self)}")
        return self._fields[name]

    @property
    def positions(self) -> NDArray[np.float64]:
        """(n, d) reference positions in the coordinates of the part, m."""
        return self.run.read(f"parts/{self.name}/position")

    @property
    def volumes(self) -> NDArray[np.float64]:
        """(n,) volumes of the nodes at the first frame, m^3."""
        return self.run.read(f"parts/{self.name}/volume")

    def in_world(self, points: ArrayLike, frame: int = -1) -> NDArray[np.float64]:
        """Points of the part in coordinates of the world: its coordinate system may lie anywhere, and move.

        Args:
            points: (n, d) m, in coordinates of the part, such as `positions` or those and a displacement.
            frame: at which frame, the last one if not given.

        Returns:
            (n, 3) m.

        Raises:
            BadInput: on points of another dimension.
            IndexError: on a frame that is not there.
        """
        places = np.asarray(points, np.float64)
        if places.ndim != 2 or places.shape[1] != self.dimension:
            raise BadInput(f"part '{self.name}': points must have the shape (n, {self.dimension}), got {places.shape}")
        origin, *axes = self.run.read(f"parts/{self.name}/placement")[: len(self.run)][frame]
        return np.asarray(places @ np.array(axes)[: self.dimension] + origin)

    def to_xarray(self, *names: str) -> Any:
        """An xarray.Dataset with these fields, or all: read as a whole, with dimensions time, node, axis, column.

        Raises:
            BadInput: if xarray is not installed.
        """
        try:
            import xarray
        except ImportError:
            raise BadInput("to_xarray needs xarray, which is not installed: python -m pip install xarray") from None
        axes = list(AXES[: self.dimension])
        arrays = {}
        for name in names or self.fields:
            field = self[name]
            told = {"units": field.unit, "long_name": field.doc, "symbol": field.symbol}
            arrays[name] = (field.dims, np.asarray(field), told)
        coordinates = {
            "time": ("time", self.run.times, {"units": "s"}),
            "step": ("time", self.run.steps),
            "axis": axes,
            "reference_position": (("node", "axis"), self.positions, {"units": "m"}),
            "volume": ("node", self.volumes, {"units": "m^3"}),
        }
        if any("column" in dims for dims, *_ in arrays.values()):
            coordinates["column"] = axes
        return xarray.Dataset(arrays, coordinates, {"part": self.name, "file": str(self.run.path)})

    def __repr__(self) -> str:
        return f"<part '{self.name}', {self.dimension}-D, {len(self)} nodes, fields {', '.join(self.fields)}>"


class RecordedField:
    """A field over time: an array (frames, n, ...) that is read when it is indexed, and only what is asked for.

    Frames, nodes and components are chosen as in numpy (a list of frames together with a list of nodes means all these
    nodes in each of these frames). `numpy.asarray(field)` reads all of it.

    Attributes:
        name, unit, symbol, doc: of the field.
        shape: of the array.
        dtype: of its entries.
        dims: names of the axes.
    """

    def __init__(self, run: Run, data: Any) -> None:
        self.run, self._place = run, data.name
        self.name = self._place.rsplit("/", 1)[1]
        self.unit, self.symbol, self.doc = (str(data.attrs[name]) for name in ("unit", "symbol", "doc"))
        self.shape, self.dtype = (len(run), *data.shape[1:]), data.dtype
        nodes = ("node",) if data.attrs["at"] == "node" else ()
        self.dims = ("time", *nodes, "axis", "column")[: len(self.shape)]

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    def __len__(self) -> int:
        return len(self.run)

    def __getitem__(self, key: Any) -> NDArray[Any]:
        import h5py

        first, *rest = self._axes(key)
        frames = np.arange(len(self))[first]
        inner = tuple(rest)
        entry = np.broadcast_to(np.zeros((), self.dtype), self.shape[1:])[inner].shape
        found = np.empty((frames.size, *entry), self.dtype)
        with h5py.File(self.run.path, "r", locking=False) as file:
            data = file[self._place]
            for row, frame in enumerate(frames.ravel()):
                # what h5py can choose is read alone, anything else from the whole frame
                found[row] = data[(frame, *inner)] if _is_simple(inner) else data[frame][inner]
        return found.reshape(*frames.shape, *entry) if frames.ndim or entry else found[0]

    def _axes(self, key: Any) -> list[Any]:
        """An index for the first axis, and the others; `...` stands for as many whole axes as there are."""
        keys = list(key) if isinstance(key, tuple) else [key]
        if any(each is Ellipsis for each in keys):
            place = next(number for number, each in enumerate(keys) if each is Ellipsis)
            whole = self.ndim - sum(each is not None for each in keys) + 1
            keys[place : place + 1] = [slice(None)] * whole
        return keys or [slice(None)]

    def at(self, time: float) -> NDArray[Any]:
        """The frame whose time is nearest, s."""
        return self[self.run.at(time)]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(self[:], dtype)

    def __repr__(self) -> str:
        return f"<field '{self.name}' [{self.unit}], {self.shape} of {self.dtype}: {self.doc}>"


def _is_simple(keys: tuple[Any, ...]) -> bool:
    """True if h5py chooses along these axes as numpy does."""
    return all(
        isinstance(key, int | np.integer) or (isinstance(key, slice) and (key.step is None or key.step > 0))
        for key in keys
    )
