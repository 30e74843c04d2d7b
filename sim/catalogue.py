"""The parts of the simulator that ship, by name: a new one is a file, and one line here.

Nothing is imported here, so that the command line can list the names without loading the
simulator.
"""

from types import MappingProxyType

__all__ = ["DRIVERS", "ENGINES", "SONAR_PRESETS", "TASKS"]

DRIVERS = MappingProxyType(
    {
        "auto": "sim.robot.drivers:auto",
        "thesis": "sim.robot.drivers:ConstantSpeeds",
        "straight": "sim.robot.drivers:STRAIGHT",
        "route": "sim.robot.drivers:route",
        "follow-left": "sim.robot.drivers:WallFollower",
        "follow-right": "sim.robot.drivers:FOLLOW_RIGHT",
        "wander": "sim.robot.drivers:RandomWander",
    }
)

ENGINES = MappingProxyType(
    {"bullet": "sim.engines.bullet:Bullet", "segments": "sim.engines.segments:Segments"}
)

SONAR_PRESETS = MappingProxyType(
    {
        "thesis": "sim.sonar.presets:THESIS",
        "aria": "sim.sonar.presets:ARIA",
        "webots": "sim.sonar.presets:WEBOTS",
        "physical": "sim.sonar.presets:PHYSICAL",
    }
)

# The environment of a task is called sonarbed/<name>-v1.
TASKS = MappingProxyType(
    {
        "Explore": "sim.envs.tasks.explore:Explore",
        "Navigate": "sim.envs.tasks.navigate:Navigate",
        "FollowWall": "sim.envs.tasks.follow_wall:FollowWall",
    }
)
