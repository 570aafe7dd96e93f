"""A picture of a frame, drawn without a screen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rbs_core.errors import BadInput

SIZE = (1000, 900)  # pixels


def draw(points: NDArray[Any], values: NDArray[np.float64], name: str, title: str, path: Path) -> None:
    """Draws nodes coloured by a field.

    Args:
        points: (n, 3) m.
        values: (n,).
        name: of the field, with its unit.
        title: what stands above.
        path: the file, .png.

    Raises:
        BadInput: where no picture can be drawn (no graphics library), or not written.
    """
    try:
        import pyvista
        from vtkmodules.vtkCommonCore import vtkLogger

        vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)  # VTK finds a way without a screen, but complains first
        plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(SIZE))
    except (ImportError, RuntimeError) as error:
        raise BadInput(f"no picture can be drawn here ({error}): open the frames in ParaView") from None
    try:
        plotter.set_background("white")
        plotter.add_mesh(
            pyvista.PolyData(np.ascontiguousarray(points, np.float64)), scalars=values, point_size=_pixels(points),
            lighting=False, show_scalar_bar=False,
        )  # fmt: skip
        plotter.add_scalar_bar(
            name, color="black", vertical=False, position_x=0.15, position_y=0.03, width=0.7, height=0.08,
            title_font_size=18, label_font_size=16, n_labels=6, fmt="%.3g",
        )  # fmt: skip
        plotter.add_text(title, font_size=12, color="black")
        if np.ptp(points[:, 2]) == 0:
            plotter.view_xy()
            plotter.enable_parallel_projection()
        plotter.screenshot(str(path))
    except OSError as error:
        raise BadInput(f"cannot write {path} ({error.strerror or error}): choose another place") from None
    finally:
        plotter.close()


def _pixels(points: NDArray[Any]) -> float:
    """Size of a node, so that the nodes of a grid about touch."""
    extents = np.ptp(points, axis=0)
    across = [float(extent) for extent in extents if extent > 0]
    if not across:
        return 60.0
    spacing = (float(np.prod(across)) / len(points)) ** (1 / len(across))
    return float(np.clip(0.8 * min(SIZE) * spacing / max(across), 1.0, 60.0))
