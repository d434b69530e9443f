"""Extras of the package: the optional modules, the extra of each, and the command to install it."""

from __future__ import annotations

import sys
from importlib.util import find_spec

from rectmerge.errors import InputError

EXTRA_OF = {
    **dict.fromkeys(("pybullet", "shapely"), "sim"),
    **dict.fromkeys(("jinja2", "matplotlib", "distributed", "tomli_w"), "bench"),
    "rosbags": "ros",
    "rclpy": "live",
    "sklearn": "dev",
}
SIMULATOR = ("pybullet", "shapely")


def require_extras(*modules: str) -> None:
    """Require modules that only an extra installs.

    Raises
    ------
    InputError
        If one is not installed; the message gives the command.
    """
    for module in modules:
        if find_spec(module) is None:
            raise InputError(f"this {missing(module)}")


def missing(module: str) -> str:
    """Return a message that a module is needed, with the command to install it."""
    text = f"needs {module.replace('_', '-')}, which is not installed: pip install 'rectmerge[{EXTRA_OF[module]}]'"
    if module == "rclpy":
        return f"{text} on Linux with Python 3.11, or source a ROS 2 of Jazzy or later and run it there"
    if module == "pybullet" and sys.version_info >= (3, 12):
        text += " with Python 3.11, for it has no wheels for later ones"
    return text
