"""Meshes made elsewhere as nodes of a part."""

from rbs_core.part.mesh.cells import Placed, placed

__all__ = ["Placed", "placed"]
