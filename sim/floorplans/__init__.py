"""Procedural buildings by family, from a seed."""

from sim.floorplans.apartment import Apartment
from sim.floorplans.clutter import Clutter
from sim.floorplans.generation import FAMILIES, families, make_world
from sim.floorplans.hall import Hall
from sim.floorplans.hospital import Hospital
from sim.floorplans.loop import Loop
from sim.floorplans.office import Office
from sim.floorplans.polygonal import Polygonal
from sim.floorplans.round import Round
from sim.floorplans.spec import WorldSpec
from sim.floorplans.two_wing import TwoWing
from sim.floorplans.warehouse import Warehouse

__all__ = [
    "FAMILIES",
    "Apartment",
    "Clutter",
    "Hall",
    "Hospital",
    "Loop",
    "Office",
    "Polygonal",
    "Round",
    "TwoWing",
    "Warehouse",
    "WorldSpec",
    "families",
    "make_world",
]
