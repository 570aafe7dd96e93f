"""Looking into the files that a run leaves: series of frames (.vtkhdf, .pvd, .h5), tables (.csv), pictures.

The formats are public (VTKHDF file format specification, docs.vtk.org): it does not matter who wrote the files.
"""

from __future__ import annotations

import csv
import re
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import BadInput

PICTURES = (".png", ".jpg", ".gif", ".svg", ".mp4")


class Series(ABC):
    """Frames of fields over time.

    Args:
        path: the file.

    Attributes:
        path: as given.
        times: of each frame, s.

    Raises:
        BadInput: if the file cannot be read.
    """

    times: list[float]

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self.times = self._times()
        except (OSError, KeyError, ValueError, ElementTree.ParseError) as error:
            raise BadInput(f"{path} cannot be read ({error}): is it complete, or still being written?") from None

    @abstractmethod
    def _times(self) -> list[float]: ...

    @abstractmethod
    def read(self, frame: int) -> tuple[NDArray[Any], dict[str, NDArray[Any]]]:
        """Points (n, 3) of a frame, m, and its fields by name, (n, ...)."""

    def number(self, frame: int) -> int:
        """The frame counted from 0; -1 is the last one.

        Raises:
            BadInput: if there is no such frame.
        """
        count = len(self.times)
        if not -count <= frame < count:
            have = f"frames 0 to {count - 1} (-1 is the last)" if count else "no frames yet"
            raise BadInput(f"{self.path} has no frame {frame}: it has {have}")
        return frame % count


def opened(path: Path) -> Any:
    """An HDF5 file to read, also while a run writes it."""
    import h5py  # only who looks into such a file needs it

    return h5py.File(path, "r", locking=False)


class OneFile(Series):
    """A .vtkhdf file with steps."""

    def _times(self) -> list[float]:
        with opened(self.path) as file:
            steps = file["VTKHDF/Steps"]
            return [float(time) for time in steps["Values"][: int(steps.attrs["NSteps"])]]

    def read(self, frame: int) -> tuple[NDArray[Any], dict[str, NDArray[Any]]]:
        with opened(self.path) as file:
            root, steps = file["VTKHDF"], file["VTKHDF/Steps"]
            counts = root["NumberOfPoints"]
            count = int(counts[min(frame, len(counts) - 1)])

            def rows(data: Any, offsets: Any) -> NDArray[Any]:
                first = int(offsets[frame])
                return np.asarray(data[first : first + count])

            fields = {name: rows(data, steps[f"PointDataOffsets/{name}"]) for name, data in root["PointData"].items()}
            return rows(root["Points"], steps["PointOffsets"]), fields


class ManyFiles(Series):
    """A .pvd file that lists one file for each time."""

    def _times(self) -> list[float]:
        found = ElementTree.parse(self.path).getroot().iter("DataSet")
        listed = [(float(each.attrib["timestep"]), each.attrib["file"]) for each in found]
        self._files = [self.path.parent / file for _, file in listed]
        return [time for time, _ in listed]

    def read(self, frame: int) -> tuple[NDArray[Any], dict[str, NDArray[Any]]]:
        import pyvista  # takes a second to load

        if not self._files[frame].is_file():
            raise BadInput(f"{self.path} names {self._files[frame].name}, which is not there: was it moved or deleted?")
        grid: Any = pyvista.read(self._files[frame])
        return np.asarray(grid.points), {name: np.asarray(grid.point_data[name]) for name in grid.point_data}


class RunFile(Series):
    """A .h5 file of a whole run: its parts together, with the node fields that all of them have."""

    def _times(self) -> list[float]:
        with opened(self.path) as file:
            return [float(time) for time in file["time"][: int(file.attrs["frames"])]]

    def read(self, frame: int) -> tuple[NDArray[Any], dict[str, NDArray[Any]]]:
        with opened(self.path) as file:
            parts = [file["parts"][name] for name in file["parts"]]
            fields = [{name: f for name, f in part["fields"].items() if f.attrs["at"] == "node"} for part in parts]
            names = [name for name in fields[0] if all(name in others for others in fields)]
            points = np.concatenate([self._placed(part, frame) for part in parts])
            return points, {name: np.concatenate([others[name][frame] for others in fields]) for name in names}

    def _placed(self, part: Any, frame: int) -> NDArray[Any]:
        """Reference positions (n, 3) in the world, m."""
        local = part["position"][:]
        origin, *axes = part["placement"][frame]
        return np.asarray(origin + local @ np.array(axes)[: local.shape[1]])


KINDS: dict[str, type[OneFile | ManyFiles | RunFile]]
KINDS = {".vtkhdf": OneFile, ".pvd": ManyFiles, ".h5": RunFile, ".hdf5": RunFile}


def series_of(folder: Path) -> list[Series]:
    """All series of frames in a folder, by name; those that cannot be read are refused when they are asked for."""
    return [KINDS[path.suffix](path) for path in sorted(folder.iterdir()) if path.suffix in KINDS]


def pictures_of(folder: Path) -> list[Path]:
    """The pictures of a folder, in the order of their names and of the numbers in them, the last one last."""

    def natural(path: Path) -> list[tuple[int, str]]:
        return [(int(piece), "") if piece.isdigit() else (-1, piece) for piece in re.split(r"(\d+)", path.name)]

    return sorted((path for path in folder.iterdir() if path.suffix in PICTURES), key=natural)


def table_of(path: Path) -> tuple[list[str], int]:
    """Names of the columns of a table, and number of its rows."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = csv.reader(file)
        return next(rows, []), sum(1 for _ in rows)


def magnitudes(values: NDArray[Any]) -> NDArray[np.float64]:
    """(n,) numbers themselves, or the magnitudes of vectors and tensors."""
    flat = np.asarray(values, np.float64)
    return flat if flat.ndim == 1 else np.sqrt((flat.reshape(len(flat), -1) ** 2).sum(axis=1))
