from .env import SonarEnv
from .environments import (
    ExploreEnv,
    ExploreVectorEnv,
    FollowWallEnv,
    FollowWallVectorEnv,
    NavigateEnv,
    NavigateVectorEnv,
)
from .episodes import EpisodeOptions, Randomisation
from .film import write_gif
from .tasks.explore import ExploreWeights
from .tasks.follow_wall import FollowWallWeights
from .tasks.navigate import NavigateWeights
from .team import TeamSpec
from .vector import SonarVectorEnv

__all__ = [
    "EpisodeOptions",
    "ExploreEnv",
    "ExploreVectorEnv",
    "ExploreWeights",
    "FollowWallEnv",
    "FollowWallVectorEnv",
    "FollowWallWeights",
    "NavigateEnv",
    "NavigateVectorEnv",
    "NavigateWeights",
    "Randomisation",
    "SonarEnv",
    "SonarVectorEnv",
    "TeamSpec",
    "write_gif",
]
