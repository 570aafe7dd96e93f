"""The configuration: parts, their nodes and their bonds."""

from rbs_core.part.neighborhoods import BondList, Bonds
from rbs_core.part.part import Part
from rbs_core.part.views import Neighborhood, Node

__all__ = ["BondList", "Bonds", "Neighborhood", "Node", "Part"]
