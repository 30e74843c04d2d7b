"""The AmigoBot in numbers: what the URDF, the odometry and the drivers agree on.

ARIA: parameter files of MobileRobots' ARIA (params/amigo-sh.p). AMRISim: MobileRobots' simulator
(PioneerRobotModels.world.inc). Rashid: the thesis (2006). Where no text gives a number it is
marked *assumed*.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

BODY_RADIUS_M = 0.18
"""Radius that ARIA plans with (RobotRadius 180)."""
BODY_HEIGHT_M = 0.15
"""Height of the body's top above the floor (AMRISim)."""
BODY_LENGTH_M, BODY_WIDTH_M = 0.330, 0.279
"""Outer dimensions of the body (AMRISim); what is drawn, not what collides."""
GROUND_CLEARANCE_M = 0.03
"""Assumed."""
WHEEL_RADIUS_M = 0.05
"""Assumed: wheels of about 100 mm diameter, unverified."""
TRACK_M = 0.24
"""Distance of the wheels' contact points, assumed: about 240 mm, unverified. ARIA's DiffConv
would imply 182 mm, which contradicts the width of the body."""
CASTER_X_M = -0.13
"""Place of the rear caster behind the axle, assumed."""
CASTER_RADIUS_M = 0.025
"""Assumed."""
MASS_KG = 3.6
"""About 3.6 kg, unverified; spread over body, wheels and the battery over the caster."""
SONAR_HEIGHT_M = 0.10
"""Height of the sonar ring above the floor, assumed: no source gives it."""

SPEED_MAX_MPS = 0.75
"""Fastest drive (AMRISim, SH)."""
TURN_MAX_RADPS = 0.87
"""Fastest turn, about 50 degrees a second (AMRISim)."""
ACCELERATION_MPS2, DECELERATION_MPS2 = 0.3, 0.75
"""Of the body along its path (AMRISim)."""

ENCODER_TICKS_PER_TURN = 500
"""Rashid, p. 58: two 500-tic shaft encoders. Taken as ticks of the wheel."""

THESIS_LEFT_MPS, THESIS_RIGHT_MPS = 0.040, 0.075
"""Wheel speeds of the thesis's drives (p. 59)."""

PHYSICS_DT_S = 0.005
"""Step of the physics, assumed: the scan periods of 175 ms and 100 ms and the 40 ms of a single
firing are whole multiples of it."""


def urdf_path() -> Path:
    """Return the path of the robot's URDF."""
    return Path(str(files("sim.robot") / "amigobot.urdf"))
