from .env import SonarEnv
from .environments import (
    ExploreEnv,
    ExploreVectorEnv,
    FollowWallEnv,
    FollowWallVectorEnv,
    NavigateEnv,
    NavigateVectorEnv,
)
from .episode_batch import BatchSpec, TeamSpec
from .episodes import EpisodeOptions, Randomisation
from .pictures.film import write_gif
from .policies.policies import Policy, frontier_policy, random_policy, wall_follow_policy
from .recording import RecordLog, record_minari
from .tasks.explore import ExploreWeights
from .tasks.follow_wall import FollowWallWeights
from .tasks.navigate import NavigateWeights
from .tasks.task import Evaluation, StepOutcome, Task, TaskSetup
from .vector import SonarVectorEnv

__all__ = [
    "BatchSpec",
    "EpisodeOptions",
    "Evaluation",
    "ExploreEnv",
    "ExploreVectorEnv",
    "ExploreWeights",
    "FollowWallEnv",
    "FollowWallVectorEnv",
    "FollowWallWeights",
    "NavigateEnv",
    "NavigateVectorEnv",
    "NavigateWeights",
    "Policy",
    "Randomisation",
    "RecordLog",
    "SonarEnv",
    "SonarVectorEnv",
    "StepOutcome",
    "Task",
    "TaskSetup",
    "TeamSpec",
    "frontier_policy",
    "random_policy",
    "record_minari",
    "wall_follow_policy",
    "write_gif",
]
