"""The configuration: parts, their nodes and their bonds."""

from rbs_core.part.connection import Connection, in_world, to_world
from rbs_core.part.host import Host
from rbs_core.part.lattice import Lattice
from rbs_core.part.layer import FictitiousLayer
from rbs_core.part.neighborhoods import Bonds
from rbs_core.part.part import Part
from rbs_core.part.rows import Rows
from rbs_core.part.views import Neighborhood, Node

__all__ = [
    "Bonds",
    "Connection",
    "FictitiousLayer",
    "Host",
    "Lattice",
    "Neighborhood",
    "Node",
    "Part",
    "Rows",
    "in_world",
    "to_world",
]
