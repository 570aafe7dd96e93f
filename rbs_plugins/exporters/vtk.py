"""VTKExporter: a PVD/VTU time series, for ParaView and PyVista."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from rbs_core import Field, Part, Trigger, always
from rbs_core.trigger import Clock
from rbs_plugins.exporters import vtu
from rbs_plugins.exporters.frames import RADIUS, FrameExporter, Room


class VTKExporter(FrameExporter):
    """Writes `<path>_<step>.vtu` for each frame and `<path>.pvd`, which lists them with their times.

    Args:
        part: the part; every node becomes a point.
        fields: what to export: node fields become point data, numbers of the part (at="part") field data.
        path: folder and beginning of the file names, e.g. "out/plate".
        configuration: "current" (default) or "reference" positions.
        radius: True to write a scalar `radius`, m, as well: that of the sphere (in 2-D disk, in 1-D segment) with the
            volume of the node, so that glyphs of this size show the body.
        when: trigger.

    Raises:
        BadInput: on a bond field or what is no field, with the nearest names; on an unknown configuration; at the start
            of the run, if the folder cannot be written.

    Files appear complete or not at all; the series is up to date after every frame.
    """

    example = {"fields": (), "path": "frames"}
    places = ("node", "part")

    def __init__(
        self,
        part: Part,
        fields: Iterable[Field],
        path: str | Path,
        *,
        configuration: str = "current",
        radius: bool = False,
        when: Trigger = always,
    ) -> None:
        super().__init__(part, fields, path, configuration=configuration, radius=radius, when=when)
        self._cells: vtu.Cells | None = None
        self._rooms: dict[str, Room] = {}

    def attach(self) -> None:
        super().attach()
        self._cells, self._rooms = None, {}  # the part may have other nodes than in an earlier run

    def apply(self, clock: Clock) -> None:
        if self._cells is None:
            self._cells = vtu.cells(len(self.part))
        # arrays live until the file is written: each has a room of its own, which the next frame uses again
        data = {field.name: self.values(field, self._room(field.name)) for field in self.node_fields}
        if self.radius:
            data[RADIUS] = self.radii()
        numbers = {field.name: self[field].reshape(1, -1) for field in self.part_fields}
        numbers["TimeValue"] = np.array([clock.time])  # by this name VTK knows the time of a single file
        points = self.positions(room=self._room(""))
        vtu.write_grid(self.frame(clock, "vtu"), vtu.Grid(points, self._cells, data, field_data=numbers))
        vtu.write_collection(self.path.with_name(f"{self.path.name}.pvd"), self.frames)

    def _room(self, name: str) -> Room:
        return self._rooms.setdefault(name, {})
