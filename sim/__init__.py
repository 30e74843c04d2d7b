"""A simulated AmigoBot with eight sonars in a known room; environments to train in.

Importing it registers the environments of `sim.envs` with Gymnasium, if that is installed.
"""

from importlib.util import find_spec

from sim.acoustics import Ears, Echoes, Sonar
from sim.air import Air
from sim.beacon import Beacon
from sim.cone import ConeSonar
from sim.drivers import ConstantSpeeds, Driver, RandomWander, Sensed, WallFollower, Waypoints
from sim.engine import Engine, RayCaster
from sim.firing import AllAtOnce, Eeruf, Firing, InTurn
from sim.odometry import OdometryModel
from sim.packets import StatusPackets
from sim.physical import PhysicalSonar
from sim.piston import Piston
from sim.receiver import Receiver
from sim.simulation import simulate

__all__ = [
    "Air",
    "AllAtOnce",
    "Beacon",
    "ConeSonar",
    "ConstantSpeeds",
    "Driver",
    "Ears",
    "Echoes",
    "Eeruf",
    "Engine",
    "Firing",
    "InTurn",
    "OdometryModel",
    "PhysicalSonar",
    "Piston",
    "RandomWander",
    "RayCaster",
    "Receiver",
    "Sensed",
    "Sonar",
    "StatusPackets",
    "WallFollower",
    "Waypoints",
    "simulate",
]

if find_spec("gymnasium") is not None:
    from sim.envs.registration import register_all

    register_all()
