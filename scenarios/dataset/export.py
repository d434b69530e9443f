"""One mission as files, for those who want data: maps for ROS, trajectories, the building, the log and the truth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import write_map
from scenarios.execution.files import clear_folder, write_json
from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import MapPair, make_pair
from sim.missions.mission_log import MissionLog
from sim.missions.trajectory import write_tum

TWO_BUILDINGS = ("other-building", "other-floor", "other-storey", "blank-halls", "mirrored")  # kinds of unrelated pairs
MISSION_FILES = (
    *("robot_[ab].png", "robot_[ab].yaml", "robot_[ab].*.tum", "world.png", "world.yaml", "mission.npz", "truth.json"),
)


def write_mission(
    folder: str | Path, log: MissionLog, pair: MapPair | None = None, *, force: bool = False
) -> list[Path]:
    """Write the data of one mission, each file whole or not at all.

    Parameters
    ----------
    folder
        Made where it does not exist.
    log
        The mission.
    pair
        A pair made from it; by default its maps by true poses, 5 cm per cell, upright and without noise.
    force
        Clear an earlier mission's files first.

    Returns
    -------
    list of Path
        ``robot_a.yaml/.png``, ``robot_b.*``
            The maps for ROS. Their origins place them in the world, up to what their poses are wrong: a map that is
            turned has a yaw. Read the PNG alone for a map whose resolution and place are not known.
        ``robot_a.truth.tum``, ``robot_b.truth.tum``
            Where the scanners were, in the world.
        ``robot_a.slam.tum``, ...
            Where the map took them to be, if it was made by other poses than the true ones.
        ``world.yaml/.png``
            The building as A's laser would see all of it, at A's resolution; what only one visit found is left out.
        ``mission.npz``
            The log, for `MissionLog.load`.
        ``truth.json``
            How the maps relate, and how they were made.

    Raises
    ------
    RectMergeError
        If the pair's maps are of two buildings, the folder holds an earlier mission and `force` is off, or a file
        cannot be written.
    """
    pair = pair or make_pair(log, MapSpec(), MapSpec(), log.seed)
    log = _as_mapped(log, pair)
    to = clear_folder(folder, MISSION_FILES, force=force)
    written = []
    for name, robot, grid, poses in zip("ab", (log.a, log.b), (pair.a, pair.b), pair.poses or (), strict=True):
        resolution, origin = pair.info[f"resolution_{name}"], tuple(pair.info[f"origin_{name}"])
        written += _written_map(to / f"robot_{name}.yaml", OccupancyGrid(grid.occupancy, resolution, origin))
        source = pair.info[f"pose_source_{name}"]
        for kind, trajectory in {"truth": robot.poses, source: poses}.items():
            written.append(to / f"robot_{name}.{kind}.tum")
            write_tum(written[-1], robot.times, trajectory)
    raster = log.world.raster(pair.info["resolution_a"], height_m=log.spec.a.lidar.height_m)
    written += _written_map(to / "world.yaml", raster)
    log.save(to / "mission.npz")
    write_json(to / "truth.json", truth_of(pair, log))
    return [*written, to / "mission.npz", to / "truth.json"]


def _as_mapped(log: MissionLog, pair: MapPair) -> MissionLog:
    """Return the log cut to the scans that the pair was made from: a pair may be cut for an overlap of its own."""
    variant = str(pair.info.get("variant", ""))
    if pair.poses is None or variant.startswith(TWO_BUILDINGS):
        raise InputError(f"{pair.pair_id}: its maps are not of one building that the log holds, so they have no place")
    whole = log.whole or log
    a, b = (
        robot.until(float(robot.times[len(poses) - 1]))
        for robot, poses in zip((whole.a, whole.b), pair.poses, strict=True)
    )
    return replace(log, a=a, b=b)


def truth_of(pair: MapPair, log: MissionLog) -> dict[str, Any]:
    """Return the truth of a pair and the settings of its maps, as plain data.

    `pixels`, `control_points` and `residual_px` are null where the maps have too little in common; `discarded` says why
    earlier tries at the mission came to nothing.
    """
    return {
        "pair_id": pair.pair_id,
        "related": pair.related,
        "pixels": pair.pixels.matrix.tolist() if pair.pixels is not None else None,
        "control_points": pair.control_points.round(4).tolist() if pair.control_points is not None else None,
        "residual_px": pair.residual_px,
        "overlap": pair.overlap,
        **pair.info,
        "discarded": list(log.discarded),
    }


def _written_map(path: Path, grid: OccupancyGrid) -> list[Path]:
    write_map(grid, path, image_suffix=".png")
    return [path, path.with_suffix(".png")]
