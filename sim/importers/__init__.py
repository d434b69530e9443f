"""Importers of foreign data: worlds from ROS maps, images, floor plans and HouseExpo plans, and CARMEN logs."""

from sim.importers.carmen import CarmenLog, read_carmen
from sim.importers.world_file import import_world

__all__ = ["CarmenLog", "import_world", "read_carmen"]
