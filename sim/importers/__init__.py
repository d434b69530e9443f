"""Worlds from files: ROS maps, images of maps and of floor plans, and HouseExpo's JSON plans."""

from sim.importers.files import import_world

__all__ = ["import_world"]
