"""A simulated AmigoBot with eight sonars in a known room; environments to train in.

Importing it registers the environments of `sim.envs` with Gymnasium, if that is installed.
"""

from importlib.util import find_spec

from sim.engines.protocol import Engine, RayCaster
from sim.robot.drivers import ConstantSpeeds, Driver, RandomWander, Sensed, WallFollower, Waypoints
from sim.robot.odometry import OdometryModel
from sim.runs.batch.drives import BatchDrive, simulate_batch
from sim.runs.many import simulate_many
from sim.runs.packets import StatusPackets
from sim.runs.replay import Replay, replay
from sim.runs.simulation import simulate
from sim.sonar.air import Air
from sim.sonar.cone.sonar import ConeSonar
from sim.sonar.firing import AllAtOnce, Eeruf, Firing, InTurn
from sim.sonar.physical.interferer import Interferer
from sim.sonar.physical.piston import Piston
from sim.sonar.physical.receiver import Receiver
from sim.sonar.physical.sonar import PhysicalSonar
from sim.sonar.physical.spread import TransducerSpread
from sim.sonar.protocol import Echoes, Sonar, SonarArray

Beacon = Interferer
"""Former name of `Interferer`."""
Ears = SonarArray
"""Former name of `SonarArray`."""

__all__ = [
    "Air",
    "AllAtOnce",
    "BatchDrive",
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
    "Interferer",
    "OdometryModel",
    "PhysicalSonar",
    "Piston",
    "RandomWander",
    "RayCaster",
    "Receiver",
    "Replay",
    "Sensed",
    "Sonar",
    "SonarArray",
    "StatusPackets",
    "TransducerSpread",
    "WallFollower",
    "Waypoints",
    "replay",
    "simulate",
    "simulate_batch",
    "simulate_many",
]

if find_spec("gymnasium") is not None:
    from sim.envs.registration import register_all

    register_all()
