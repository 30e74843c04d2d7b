"""A simulated AmigoBot with eight sonars in a known room."""

from sim.acoustics import Echoes, Sonar
from sim.cone import ConeSonar
from sim.drivers import ConstantSpeeds, Driver, RandomWander, Sensed, WallFollower, Waypoints
from sim.engine import Engine, RayCaster
from sim.odometry import OdometryModel
from sim.simulation import simulate

__all__ = [
    "ConeSonar",
    "ConstantSpeeds",
    "Driver",
    "Echoes",
    "Engine",
    "OdometryModel",
    "RandomWander",
    "RayCaster",
    "Sensed",
    "Sonar",
    "WallFollower",
    "Waypoints",
    "simulate",
]
