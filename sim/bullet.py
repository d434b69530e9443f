"""Physics in PyBullet: a client with one building, robots driven by their wheels, laser rays and a camera.

Collision groups say which bodies collide: the floor, walls and furniture, glass, the objects of each visit, and every
robot are groups of their own. The rays of a robot ask for walls, objects of its own visit and other robots, or for
glass.
"""

from __future__ import annotations

import contextlib
import functools
import math
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError, SimulationError
from rectmerge.extras import missing
from sim.meshes import build_facets, build_mesh, cut_at_height
from sim.sensors.lidar import RayHits
from sim.world import Prism, World

WHEEL_RADIUS_M, TRACK_M = 0.05, 0.28  # as in robot.urdf
WHEEL_TORQUE_NM = 2.0
RAY_BIT, FLOOR_BIT, SOLID_BIT, GLASS_BIT = 1, 2, 4, 8  # collision groups; rays are in PyBullet's first
VISIT_BITS = (16, 32)
BOTH_ASK = 0  # two bodies touch if both ask for each other; unasked, PyBullet takes either for enough
FIRST_ROBOT_BIT, MOST_ROBOTS = 64, 16
ROBOT_BITS = FIRST_ROBOT_BIT * (2**MOST_ROBOTS - 1)
MOST_RAYS = 3999  # a larger batch comes back empty without a word
MOST_SHOWN_VERTICES = 3 * 40_000  # a visual shape takes 131,072, and these are three by three
SOLVER_ITERATIONS = 10
CAMERA_FOV_DEG, CUT_M = 30.0, 1.3  # pictures show walls and furniture cut at this height
FURNITURE_RGBA = [0.58, 0.42, 0.28, 1.0], [0.80, 0.52, 0.25, 1.0], [0.40, 0.45, 0.30, 1.0]  # both visits', A's, B's
URDF = Path(__file__).parent / "robot.urdf"


@contextlib.contextmanager
def physics(world: World, *, hz: int = 60) -> Iterator[Physics]:
    """Open a physics client with a world in it; the client is closed at the end, also after an error.

    Raises
    ------
    SimulationError
        If PyBullet is not installed or gives no client.
    """
    bullet = _pybullet()
    client = bullet.connect(bullet.DIRECT)
    if client < 0:
        raise SimulationError("PyBullet gave no physics client: too many are open in this process")
    try:
        yield Physics(bullet, client, world, hz)
    finally:
        bullet.disconnect(physicsClientId=client)


class _Robot(NamedTuple):
    """Robot of the engine: the joints of its wheels, and the collision groups that its rays ask for."""

    wheels: tuple[int, int]
    meets: int


class Physics:
    """Simulation of one building: robots touch everything but the objects of the other visit; see `physics`."""

    def __init__(self, bullet: Any, client: int, world: World, hz: int) -> None:
        self._bullet, self._client, self._world = bullet, client, world
        self._robots: dict[int, _Robot] = {}
        self._has_colours = False
        bullet.setGravity(0, 0, -9.81, physicsClientId=client)
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=1.0 / hz,
            numSolverIterations=SOLVER_ITERATIONS,
            deterministicOverlappingPairs=1,
            collisionFilterMode=BOTH_ASK,
            physicsClientId=client,
        )
        self._stand(bullet.createCollisionShape(bullet.GEOM_PLANE, physicsClientId=client), FLOOR_BIT)
        parts = ((world.walls + world.furniture, SOLID_BIT), (world.glass, GLASS_BIT))
        for prisms, group in (*parts, *zip(world.visits, VISIT_BITS, strict=True)):
            if prisms:
                self._stand(self._trimesh(prisms), group)

    def _trimesh(self, prisms: Iterable[Prism]) -> int:
        vertices, triangles = build_mesh(prisms)
        shape: int = self._bullet.createCollisionShape(
            self._bullet.GEOM_MESH,
            vertices=vertices.tolist(),
            indices=triangles.ravel().tolist(),
            flags=self._bullet.GEOM_FORCE_CONCAVE_TRIMESH,
            physicsClientId=self._client,
        )
        return shape

    def _stand(self, shape: int, group: int) -> None:
        """Add a body that never moves, without a visual shape: `camera` adds those."""
        body, client = self._static(collision=shape), self._client
        self._bullet.setCollisionFilterGroupMask(body, -1, group, ROBOT_BITS | RAY_BIT, physicsClientId=client)
        self._bullet.changeVisualShape(body, -1, rgbaColor=[1, 1, 1, 0], physicsClientId=client)

    def add_robot(self, pose: NDArray[np.float64], *, visit: int = 0) -> int:
        """Put a robot at a pose and return its number.

        Parameters
        ----------
        pose
            (x, y, yaw).
        visit
            Objects that it meets: 0 for those of the visit of A, 1 for B.

        Raises
        ------
        InputError
            If there is no such visit, or there are 16 robots already.
        """
        if visit not in (0, 1) or len(self._robots) == MOST_ROBOTS:
            raise InputError(f"a robot needs visit 0 or 1 and one of {MOST_ROBOTS} places, got visit {visit}")
        bullet, client = self._bullet, self._client
        turn = bullet.getQuaternionFromEuler([0.0, 0.0, float(pose[2])])
        at = [float(pose[0]), float(pose[1]), 0.002]
        robot: int = bullet.loadURDF(
            str(URDF), at, turn, flags=bullet.URDF_USE_IMPLICIT_CYLINDER, physicsClientId=client
        )
        count = bullet.getNumJoints(robot, physicsClientId=client)
        names = {bullet.getJointInfo(robot, k, physicsClientId=client)[12].decode(): k for k in range(count)}
        wheels, group = (names["left_wheel"], names["right_wheel"]), FIRST_ROBOT_BIT << len(self._robots)
        self._robots[robot] = _Robot(wheels, SOLID_BIT | VISIT_BITS[visit] | ROBOT_BITS & ~group)
        touches = FLOOR_BIT | SOLID_BIT | GLASS_BIT | VISIT_BITS[visit] | ROBOT_BITS
        meets = {-1: touches | RAY_BIT, names["mast"]: RAY_BIT}  # the mast stops rays only, wheels and casters none
        for link in range(-1, count):
            bullet.setCollisionFilterGroupMask(robot, link, group, meets.get(link, touches), physicsClientId=client)
            bullet.changeDynamics(robot, link, lateralFriction=1.0 if link in wheels else 0.01, physicsClientId=client)
        return robot

    def drive(self, robot: int, speed_m_s: float, turn_rad_s: float) -> None:
        """Set the speeds of the wheels for a forward speed and a rate of turn."""
        aside = turn_rad_s * TRACK_M / 2
        self._bullet.setJointMotorControlArray(
            robot,
            self._robots[robot].wheels,
            self._bullet.VELOCITY_CONTROL,
            targetVelocities=[(speed_m_s - aside) / WHEEL_RADIUS_M, (speed_m_s + aside) / WHEEL_RADIUS_M],
            forces=[WHEEL_TORQUE_NM, WHEEL_TORQUE_NM],
            physicsClientId=self._client,
        )

    def step(self) -> None:
        """Advance by one time step."""
        self._bullet.stepSimulation(physicsClientId=self._client)

    def pose(self, robot: int) -> NDArray[np.float64]:
        """Return the pose of a robot, (x, y, yaw)."""
        at, turn = self._bullet.getBasePositionAndOrientation(robot, physicsClientId=self._client)
        x, y, z, w = turn
        return np.array([at[0], at[1], math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))])

    def wheel_angles(self, robot: int) -> tuple[float, float]:
        """Return the angles by which the left and the right wheel have turned, radians."""
        left, right = self._bullet.getJointStates(robot, self._robots[robot].wheels, physicsClientId=self._client)
        return float(left[0]), float(right[0])

    def cast(self, robot: int, angles: NDArray[np.float64], max_range_m: float, height_m: float) -> RayHits:
        """Cast rays from a robot, level, in the plane of its scanner.

        Parameters
        ----------
        robot
            Its number; it never meets itself.
        angles
            Shape (N,), radians from its heading.
        max_range_m
            Length of the rays.
        height_m
            Of the scanner above the floor; robots meet each other's rays from 0.05 to 0.65 m.

        Returns
        -------
        Reading
            Distances to the bodies that robots touch, glass apart, without the objects of the other visit.

        Notes
        -----
        Rays that start inside another robot do not meet it; those that start inside a prism meet it from within.
        """
        pose = self.pose(robot)
        heading = pose[2] + angles
        start = np.array([pose[0], pose[1], height_m])
        reach = np.stack([np.cos(heading), np.sin(heading), np.zeros_like(heading)], axis=-1) * max_range_m  # (N, 3)
        ranges = self._cast(start, reach, self._robots[robot].meets) * max_range_m
        glass = np.full(len(angles), np.inf)
        if self._world.glass:
            glass = self._cast(start, reach, GLASS_BIT) * max_range_m
        return RayHits(ranges, np.where(glass < ranges, glass, np.inf))

    def _cast(self, start: NDArray[np.float64], reach: NDArray[np.float64], mask: int) -> NDArray[np.float64]:
        """Return the share of each ray's reach at which it meets one of the groups; inf where it meets none."""
        ends, hits = (start + reach).tolist(), []
        for k in range(0, len(ends), MOST_RAYS):
            part = ends[k : k + MOST_RAYS]
            hits += self._bullet.rayTestBatch(
                [start.tolist()] * len(part), part, collisionFilterMask=mask, physicsClientId=self._client
            )
        if len(hits) != len(ends):
            raise SimulationError(f"PyBullet answered {len(hits)} of {len(ends)} rays")
        return np.array([hit[2] if hit[0] >= 0 else np.inf for hit in hits])

    def camera(self, width: int = 800, height: int = 600) -> NDArray[np.uint8]:
        """Take a picture from above at a slant, with walls cut low; return shape (height, width, 3), RGB.

        Raises
        ------
        InputError
            If the picture has no pixels or more than 4096 on a side.
        """
        if not (1 <= width <= 4096 and 1 <= height <= 4096):
            raise InputError(f"a picture is 1 to 4096 pixels each way, got {width} x {height}")
        self._colour()
        bullet, client, (sx, sy) = self._bullet, self._client, self._world.size
        slant = math.radians(24)
        reach = max(sx * height / width, sy) * 0.57 / math.tan(math.radians(CAMERA_FOV_DEG / 2)) + CUT_M
        eye = [sx / 2, sy / 2 - reach * math.sin(slant), reach * math.cos(slant)]
        view = bullet.computeViewMatrix(eye, [sx / 2, sy / 2, 0.0], [0, 1, 0])
        lens = bullet.computeProjectionMatrixFOV(CAMERA_FOV_DEG, width / height, 1.0, 4 * reach)
        picture = bullet.getCameraImage(
            width,
            height,
            view,
            lens,
            lightDirection=[-6.0, -9.0, 20.0],
            shadow=1,
            renderer=bullet.ER_TINY_RENDERER,
            physicsClientId=client,
        )[2]
        return np.asarray(picture, dtype=np.uint8).reshape(height, width, 4)[..., :3].copy()

    def _colour(self) -> None:
        """Add the visual shapes of all bodies, once, before the first picture."""
        if self._has_colours:
            return
        self._has_colours = True
        (sx, sy), far = self._world.size, max(self._world.size)
        earth = Prism(np.array([[-far, -far], [sx + far, -far], [sx + far, sy + far], [-far, sy + far]]), 1.0)
        self._show([earth], [0.46, 0.52, 0.44, 1.0], drop=1.02)
        self._show([Prism(outline, 1.0) for outline in self._world.ground], [0.80, 0.74, 0.66, 1.0], drop=1.0)
        self._show(cut_at_height(self._world.walls, CUT_M), [0.93, 0.93, 0.91, 1.0])
        self._show(cut_at_height(self._world.glass, CUT_M), [0.62, 0.84, 0.95, 1.0])
        for prisms, colour in zip((self._world.furniture, *self._world.visits), FURNITURE_RGBA, strict=True):
            self._show(cut_at_height(prisms, CUT_M - 0.05), colour)

    def _show(self, prisms: Iterable[Prism], colour: list[float], drop: float = 0.0) -> None:
        corners, normals = build_facets(prisms)
        for first in range(0, len(corners), MOST_SHOWN_VERTICES):
            part = slice(first, first + MOST_SHOWN_VERTICES)
            shape = self._bullet.createVisualShape(
                self._bullet.GEOM_MESH,
                vertices=(corners[part] - [0, 0, drop]).tolist(),
                indices=list(range(len(corners[part]))),
                normals=normals[part].tolist(),
                rgbaColor=colour,
                specularColor=[0.05, 0.05, 0.05],
                physicsClientId=self._client,
            )
            self._static(visual=shape)

    def _static(self, collision: int = -1, visual: int = -1) -> int:
        body: int = self._bullet.createMultiBody(0.0, collision, visual, [0.0, 0.0, 0.0], physicsClientId=self._client)
        return body


@functools.cache
def _pybullet() -> Any:
    """Import PyBullet, which prints a line on the error stream from C."""
    sys.stderr.flush()
    try:
        kept = os.dup(2)
    except OSError:  # there is no error stream to keep clean
        return _import()
    try:
        with Path(os.devnull).open("wb") as nowhere:
            os.dup2(nowhere.fileno(), 2)
            return _import()
    finally:
        os.dup2(kept, 2)
        os.close(kept)


def _import() -> Any:
    try:
        import pybullet
    except ImportError as error:
        raise SimulationError(f"the simulation {missing('pybullet')}") from error
    return pybullet
