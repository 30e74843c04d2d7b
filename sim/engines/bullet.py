"""The one door to PyBullet: connection, bodies, rays and motion."""

from __future__ import annotations

import ctypes
import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import chain, pairwise
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from sim.engines.protocol import ClosedByWith
from sim.robot import amigobot
from sim.robot.kinematics import limited_speeds
from sonarmap.errors import InputError
from sonarmap.kernels.jit import njit
from worlds import Pose, RayHits, Solid, World

__all__ = ["Bullet"]

# Rays are of group 1 and see group 1 only; the robot, in group 2, meets the world but no ray does
# meet it. PyBullet's own groups would put the walls, being static, into group 2.
_WORLD_GROUP, _ROBOT_GROUP = 1, 2
# PyBullet loses a batch of exactly 16384 rays: its C code needs strictly less than the limit that
# its Python side accepts. 4096 is macOS's limit.
_RAYS_A_CALL = 4095
# Wheels are driven by speed; the robot's own acceleration limits are imposed on that speed, so the
# motor only has to be strong enough. Newton metres, assumed.
_MOTOR_TORQUE_NM = 5.0
# Contact is looked for this often: a robot at full speed moves 37 mm meanwhile, and whoever drives
# against a wall stays there.
_TOUCH_PERIOD_S = 0.05
_SETTLE_S = 0.1
_GRAVITY_MPS2 = 9.81


class Bullet(ClosedByWith):
    """A world with an AmigoBot in PyBullet; use it by ``with``.

    Parameters
    ----------
    world : World
        The room. Solids become their outlines, extruded; rays meet pillars as exact circles.
    start : Pose
        Where the robot begins, clear of every solid.
    gui : bool
        Show PyBullet's window.
    """

    def __init__(self, world: World, start: Pose, *, gui: bool = False) -> None:
        self._p = _pybullet()
        if gui:
            _check_display()
        self._client: int | None = self._p.connect(self._p.GUI if gui else self._p.DIRECT)
        if self._client is None or self._client < 0:
            raise InputError("engine 'bullet': no connection (with gui: is there a display?)")
        try:
            self._build(world)
            self._add_robot(start)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Disconnect; closing twice is fine."""
        client, self._client = self._client, None
        if client is not None and client >= 0:
            self._p.disconnect(physicsClientId=client)

    def __getstate__(self) -> NoReturn:
        """Refuse to be copied or pickled: the robot and the room live in PyBullet's memory."""
        raise TypeError(
            "engine 'bullet' can be neither copied nor pickled: its state is PyBullet's; "
            "engine 'segments' can"
        )

    @property
    def pose(self) -> Pose:
        """True pose of the robot."""
        (x_m, y_m, _), (_, _, z, w) = self._p.getBasePositionAndOrientation(
            self._robot, physicsClientId=self._client
        )
        return Pose(x_m, y_m, 2 * math.atan2(z, w))

    @property
    def wheel_turns_rad(self) -> tuple[float, float]:
        """How far the left and right wheel have turned since the start, radians."""
        left, right = self._p.getJointStates(
            self._robot, self._wheels, physicsClientId=self._client
        )
        return left[0] - self._turned_before[0], right[0] - self._turned_before[1]

    def advance(self, left_mps: float, right_mps: float, duration_s: float) -> bool:
        """Drive towards the given wheel speeds; return whether the robot touched something."""
        dt_s = amigobot.PHYSICS_DT_S
        between_looks = round(_TOUCH_PERIOD_S / dt_s)
        steps = round(duration_s / dt_s)
        touched, settled = False, False
        for step in range(1, steps + 1):
            if not settled:
                speeds = limited_speeds(self._speeds, (left_mps, right_mps), dt_s)
                settled = speeds == self._speeds
                self._command(speeds)
            self._p.stepSimulation(physicsClientId=self._client)
            if step % between_looks == 0 or step == steps:
                touched = touched or self._touches()
        return touched

    def cast(
        self,
        origins_xy_m: NDArray[np.float64],
        directions_xy: NDArray[np.float64],
        range_max_m: NDArray[np.float64],
    ) -> RayHits:
        """Return the first surface within ``range_max_m`` of each ray, at sonar height."""
        n = len(origins_xy_m)
        begin, end = _ends(origins_xy_m, directions_xy, range_max_m)
        hits: list[tuple[Any, ...]] = []
        for first in range(0, n, _RAYS_A_CALL):
            rows = slice(first, first + _RAYS_A_CALL)
            hits += self._p.rayTestBatch(
                begin[rows],
                end[rows],
                collisionFilterMask=_WORLD_GROUP,
                physicsClientId=self._client,
            )
        if len(hits) != n:
            raise RuntimeError(f"PyBullet answered {len(hits)} of {n} rays")
        if not hits:
            return RayHits(np.empty(0), np.empty((0, 2)), np.empty(0, np.int32))
        body, _, fraction, _, normal = zip(*hits, strict=True)
        # Flat, because numpy is slow at reading tuples within tuples.
        flat = chain.from_iterable(normal)
        return RayHits(
            *_met(
                np.fromiter(body, np.int64, n),
                np.fromiter(fraction, float, n),
                np.fromiter(flat, float, 3 * n).reshape(n, 3),
                origins_xy_m,
                directions_xy,
                range_max_m,
                self._surface_of_body,
                self._circles,
            )
        )

    def _build(self, world: World) -> None:
        p, client = self._p, self._client
        p.setTimeStep(amigobot.PHYSICS_DT_S, physicsClientId=client)
        p.setGravity(0, 0, -_GRAVITY_MPS2, physicsClientId=client)
        floor = p.createCollisionShape(p.GEOM_PLANE, physicsClientId=client)
        bodies = [p.createMultiBody(0, floor, physicsClientId=client)]
        bodies += [self._add_solid(solid) for solid in world.solids]
        # The floor and "no body" (-1, the array's last entry) are no surfaces.
        self._surface_of_body = np.full(max(bodies) + 3, -1, np.int32)
        self._surface_of_body[bodies[1:]] = np.arange(len(world.solids))
        for body in bodies:
            p.setCollisionFilterGroupMask(
                body, -1, _WORLD_GROUP, _WORLD_GROUP | _ROBOT_GROUP, physicsClientId=client
            )
        self._floor = bodies[0]
        # One entry more: surface -1 is the last.
        circles = [solid.circle or (0.0, 0.0, 0.0) for solid in world.solids]
        self._circles = np.array([*circles, (0.0, 0.0, 0.0)])

    def _add_solid(self, solid: Solid) -> int:
        p, client = self._p, self._client
        vertices, triangles = _extruded(solid)
        shape = p.createCollisionShape(
            p.GEOM_MESH, vertices=vertices, indices=triangles, physicsClientId=client
        )
        body: int = p.createMultiBody(
            baseMass=0, baseCollisionShapeIndex=shape, physicsClientId=client
        )
        if body < 0:
            raise RuntimeError(f"PyBullet could not build {solid.name!r}")
        return body

    def _add_robot(self, start: Pose) -> None:
        p, client = self._p, self._client
        self._robot = p.loadURDF(
            str(amigobot.urdf_path()),
            basePosition=(start.x_m, start.y_m, 0.0),
            baseOrientation=p.getQuaternionFromEuler((0, 0, start.heading_rad)),
            physicsClientId=client,
        )
        joints = {
            p.getJointInfo(self._robot, joint, physicsClientId=client)[1].decode(): joint
            for joint in range(p.getNumJoints(self._robot, physicsClientId=client))
        }
        self._wheels = [joints["left_wheel_joint"], joints["right_wheel_joint"]]
        for link in range(-1, len(joints)):
            p.setCollisionFilterGroupMask(
                self._robot, link, _ROBOT_GROUP, _WORLD_GROUP, physicsClientId=client
            )
            # Damping is a fudge for flying bodies; motors and friction do the braking here.
            p.changeDynamics(
                self._robot, link, linearDamping=0, angularDamping=0, physicsClientId=client
            )
        p.changeDynamics(
            self._robot, joints["caster_joint"], lateralFriction=0, physicsClientId=client
        )
        for wheel in self._wheels:
            p.changeDynamics(self._robot, wheel, lateralFriction=1, physicsClientId=client)
        self._turned_before = (0.0, 0.0)
        self._command((0.0, 0.0))
        self.advance(0.0, 0.0, _SETTLE_S)
        self._turned_before = self.wheel_turns_rad

    def _command(self, speeds_mps: tuple[float, float]) -> None:
        self._speeds = speeds_mps
        self._p.setJointMotorControlArray(
            self._robot,
            self._wheels,
            self._p.VELOCITY_CONTROL,
            targetVelocities=[speed / amigobot.WHEEL_RADIUS_M for speed in speeds_mps],
            forces=[_MOTOR_TORQUE_NM, _MOTOR_TORQUE_NM],
            physicsClientId=self._client,
        )

    def _touches(self) -> bool:
        contacts = self._p.getContactPoints(self._robot, physicsClientId=self._client)
        # Index 2 is the other body, 8 the distance: positive while only near.
        return any(contact[2] != self._floor and contact[8] <= 0 for contact in contacts)


def _extruded(solid: Solid) -> tuple[list[tuple[float, float, float]], list[int]]:
    """Return vertices and triangles of the upright faces of a solid."""
    vertices: list[tuple[float, float, float]] = []
    triangles: list[int] = []
    for ring in (solid.outline.exterior, *solid.outline.interiors):
        corners = list(ring.coords)
        for (x0, y0), (x1, y1) in pairwise(corners):
            a = len(vertices)
            vertices += [(x0, y0, 0.0), (x1, y1, 0.0)]
            vertices += [(x1, y1, solid.height_m), (x0, y0, solid.height_m)]
            triangles += [a, a + 1, a + 2, a, a + 2, a + 3]
    return vertices, triangles


@njit()
def _ends(origins_xy_m, directions_xy, range_max_m):  # type: ignore[no-untyped-def]
    """Return where rays begin and end, at sonar height, shapes (n, 3)."""
    n = range_max_m.size
    begin, end = np.empty((n, 3)), np.empty((n, 3))
    for i in range(n):
        for axis in range(2):
            begin[i, axis] = origins_xy_m[i, axis]
            end[i, axis] = origins_xy_m[i, axis] + range_max_m[i] * directions_xy[i, axis]
        begin[i, 2] = end[i, 2] = amigobot.SONAR_HEIGHT_M
    return begin, end


@njit()
def _met(body, fraction, normal, origins_xy_m, directions_xy, range_max_m, surface_of, circles):  # type: ignore[no-untyped-def]
    """Return (distance, normal, surface) of what PyBullet says that rays have met.

    A pillar is a prism for PyBullet: its own cylinders are up to 20 mm and 10 degrees off where a
    ray grazes them, and catch rays that pass. Which body is met it reports correctly; the rest
    follows from the exact circle (x, y, radius; radius 0 for what is no pillar).
    """
    n = body.size
    distance_m, normal_xy, surface = np.empty(n), np.empty((n, 2)), np.empty(n, np.int32)
    for i in range(n):
        surface[i] = surface_of[body[i]]
        distance_m[i] = fraction[i] * range_max_m[i] if surface[i] >= 0 else np.inf
        normal_xy[i, 0], normal_xy[i, 1] = normal[i, 0], normal[i, 1]
        radius = circles[surface[i], 2]
        if radius > 0.0:
            dx, dy = directions_xy[i, 0], directions_xy[i, 1]
            ax = circles[surface[i], 0] - origins_xy_m[i, 0]
            ay = circles[surface[i], 1] - origins_xy_m[i, 1]
            along, aside = ax * dx + ay * dy, ax * dy - ay * dx
            distance_m[i] = along - math.sqrt(max(radius * radius - aside * aside, 0.0))
            ox, oy = distance_m[i] * dx - ax, distance_m[i] * dy - ay
            length = math.hypot(ox, oy)
            normal_xy[i, 0], normal_xy[i, 1] = ox / length, oy / length
    return distance_m, normal_xy, surface


def _check_display() -> None:
    """Raise `InputError` if no window can be shown: PyBullet would end the whole process."""
    if not sys.platform.startswith("linux"):
        return
    where = os.environ.get("DISPLAY")
    if not where:
        problem = "DISPLAY is not set"
    else:
        try:
            x11 = ctypes.CDLL("libX11.so.6")
        except OSError:
            problem = "libX11.so.6 is not installed"
        else:
            x11.XOpenDisplay.restype = ctypes.c_void_p
            shown = x11.XOpenDisplay(None)
            if shown:
                x11.XCloseDisplay(ctypes.c_void_p(shown))
                return
            problem = f"nothing answers at DISPLAY={where}"
    raise InputError(
        f"gui needs a display to show its window on, and there is none: {problem}; without gui "
        "nothing is shown, and the log is the same"
    )


def _pybullet() -> Any:
    try:
        with _silent_stderr():  # it greets with its build time
            import pybullet
    except ImportError:
        raise InputError(
            "engine 'bullet' needs PyBullet: install the extra, pip install 'sonarbed[sim]'"
        ) from None
    return pybullet


@contextmanager
def _silent_stderr() -> Iterator[None]:
    """Send what C code writes to standard error away for a moment."""
    try:
        kept = os.dup(2)
    except OSError:  # it is closed: nobody hears
        yield
        return
    try:
        with open(os.devnull, "wb") as nowhere:  # noqa: PTH123 - a device, not a path of ours
            os.dup2(nowhere.fileno(), 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
