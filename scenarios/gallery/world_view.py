"""View of a world: made from a family or a file, described in text, drawn by PyBullet's camera."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError, SimulationError
from rectmerge.io.atomic_file import replace_file
from rectmerge.io.image_file import encode_image
from rectmerge.io.map_file import map_files
from sim.bullet import physics
from sim.floorplans import FAMILIES, WorldSpec, families, make_world
from sim.importers import import_world
from sim.motion.driving import CELL_M, make_drive_field
from sim.world import World

WIDTH, LEAST_HEIGHT, MOST_HEIGHT = 1240, 420, 1640  # of a picture, pixels
SLANT = 0.96  # share of the ground's depth in an oblique picture
MARGIN = 0.08  # of the picture's width, above and below the building
NAMED_ROOMS = 8


def list_families() -> str:
    """Return a text of every family and its parameters with defaults, in TOML; the shared ones last."""
    shared = _parameters(dataclasses.fields(WorldSpec))
    lines = []
    for name, about in families().items():
        own = {
            parameter: text
            for parameter, text in _parameters(dataclasses.fields(FAMILIES[name])).items()
            if shared.get(parameter) != text
        }
        lines += [f"{name}: {about}", f"    {', '.join(own.values())}"]
    return "\n".join([*lines, "every family, unless it says otherwise:", f"    {', '.join(shared.values())}"])


def write_picture(what: str, output: Path | None, *, seed: int | None = None, resolution: float | None = None) -> str:
    """Draw the world that `find_world` finds into a PNG file and return its description.

    Raises
    ------
    InputError
        As `find_world`; also if the output is missing, no PNG, the input itself, or cannot be written.
    SimulationError
        As `find_world`; also if PyBullet is missing.
    """
    world = find_world(what, seed=seed, resolution=resolution)
    if output is None:
        raise InputError(f"name the picture of {what} with -o PICTURE.png")
    if output.suffix.lower() != ".png":
        raise InputError(f"{output}: the picture is a PNG; give it a name that ends in .png")
    if output.resolve() in {file.resolve() for file in _files(what)}:
        raise InputError(f"{output}: is the file itself; name another picture with -o")
    replace_file(output, encode_image(draw_world(world), ".png"))
    return f"{describe_world(world)}\n  picture      {output}"


def find_world(what: str, *, seed: int | None = None, resolution: float | None = None) -> World:
    """Make the world of a family or a file; a family wins over a file of its name.

    Parameters
    ----------
    what
        A family, or a file that `sim.importers.import_world` reads.
    seed
        Seed of a family's building; None is 0.
    resolution
        Metres per pixel of a file without them.

    Raises
    ------
    InputError
        If there is no such family or file, the file cannot be read, or an option does not apply to it.
    SimulationError
        If no drivable building was found.
    """
    if what in FAMILIES:
        if resolution is not None:
            raise InputError(f"{what} is a family, which has no pixels: leave out --resolution")
        return make_world(FAMILIES[what](), seed or 0)
    if not Path(what).suffix and not Path(what).exists():
        known = ", ".join(FAMILIES)
        raise InputError(f"no family {what!r}; there are: {known}, or name a file (.yaml, .json or an image)")
    if seed is not None:
        raise InputError(f"{what} is a file, which is one building: leave out --seed")
    return import_world(what, resolution=resolution)


def draw_world(world: World) -> NDArray[np.uint8]:
    """Take the camera's picture of a world, as tall as its plan; shape (height, 1240, 3), RGB."""
    height = round(WIDTH * (SLANT * world.size[1] / world.size[0] + MARGIN))
    with physics(world) as engine:
        return engine.camera(WIDTH, min(MOST_HEIGHT, max(LEAST_HEIGHT, height)))


def describe_world(world: World) -> str:
    """Return a world's size, rooms and doors as lines for the terminal."""
    names = ", ".join(room.name for room in world.rooms[:NAMED_ROOMS])
    more = ", ..." if len(world.rooms) > NAMED_ROOMS else ""
    shut = sum(not door.is_open for door in world.doors)
    lines = [
        f"  world        {world.family or 'unnamed'}, seed {world.seed}",
        f"  size         {world.size[0]:.1f} x {world.size[1]:.1f} m",
        f"  rooms        {len(world.rooms)}{': ' if names else ''}{names}{more}",
        f"  doors        {len(world.doors)}" + (f", {shut} of them shut" if shut else ""),
        f"  drivable     {_drivable(world)}",
    ]
    if any(world.visits):
        lines.append("  visits       orange stands only while A maps, green only while B does")
    return "\n".join(lines)


def _parameters(fields: Iterable[dataclasses.Field[Any]]) -> dict[str, str]:
    """Return the fields that a suite can set, each as TOML with its default."""
    return {field.name: f"{field.name} = {json.dumps(field.default)}" for field in fields if field.init}


def _files(what: str) -> tuple[Path, ...]:
    """Return the files that a world is read from."""
    return () if what in FAMILIES else map_files(what)


def _drivable(world: World) -> str:
    try:
        area = make_drive_field(world).is_drivable.sum() * CELL_M**2
    except SimulationError:
        return "nothing: a robot fits nowhere"
    return f"{area:.0f} square metres"
