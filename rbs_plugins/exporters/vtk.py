"""VTKExporter: a PVD/VTU time series, for ParaView and PyVista."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from rbs_core import Field, Part, Trigger, always
from rbs_core.files import written_whole
from rbs_core.trigger import Clock
from rbs_plugins.exporters.frames import FrameExporter


class VTKExporter(FrameExporter):
    """Writes `<path>_<step>.vtu` for each frame and `<path>.pvd`, which lists them with their times.

    Args:
        part: the part; every node becomes a point.
        fields: node fields to export.
        path: folder and beginning of the file names, e.g. "out/plate".
        configuration: "current" (default) or "reference" positions.
        when: trigger.

    Files appear complete or not at all; the series is up to date after every frame.
    """

    example = {"fields": (), "path": "frames"}

    def __init__(
        self,
        part: Part,
        fields: Iterable[Field],
        path: str | Path,
        *,
        configuration: str = "current",
        when: Trigger = always,
    ) -> None:
        super().__init__(part, fields, path, configuration=configuration, when=when)
        self._grid: Any = None

    def attach(self) -> None:
        super().attach()
        self._grid = None  # the part may have other nodes than in an earlier run

    def apply(self, clock: Clock) -> None:
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

        if self._grid is None:
            self._grid = self._cells()
        # VTK keeps pointers into these arrays until the file is written
        held = [self.positions(), *(np.ascontiguousarray(self.values(field)) for field in self.fields)]
        self._grid.GetPoints().SetData(numpy_to_vtk(held[0]))
        data = self._grid.GetPointData()
        data.Initialize()
        for field, values in zip(self.fields, held[1:], strict=True):
            array = numpy_to_vtk(values)
            array.SetName(field.name)
            data.AddArray(array)
        file = self.frame(clock, "vtu")
        with written_whole(file) as partial:
            writer = vtkXMLUnstructuredGridWriter()
            writer.SetInputData(self._grid)
            writer.SetFileName(str(partial))
            writer.SetDataModeToAppended()
            writer.EncodeAppendedDataOff()
            writer.SetCompressorTypeToNone()
            if not writer.Write():
                raise OSError(f"{self.label} cannot write {file}: is the disk full?")
        self._write_series()

    def _cells(self) -> Any:
        """A grid with one vertex cell per node; points and data are exchanged for each frame."""
        from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import VTK_VERTEX, vtkCellArray, vtkUnstructuredGrid

        count = len(self.part)
        cells = vtkCellArray()
        offsets, nodes = np.arange(count + 1, dtype=np.int64), np.arange(count, dtype=np.int64)
        cells.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(nodes, deep=True))
        grid = vtkUnstructuredGrid()
        grid.SetPoints(vtkPoints())
        grid.SetCells(VTK_VERTEX, cells)
        return grid

    def _write_series(self) -> None:
        rows = "\n".join(
            f'    <DataSet timestep="{time!r}" group="" part="0" file={quoteattr(name)}/>' for time, name in self.frames
        )
        head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>'
        text = f"{head}\n{rows}\n  </Collection>\n</VTKFile>\n"
        with written_whole(self.path.with_name(f"{self.path.name}.pvd")) as partial:
            partial.write_text(text, encoding="utf-8")
