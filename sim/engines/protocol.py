"""What the simulator asks of an engine: rays and motion, nothing else."""

from __future__ import annotations

from types import TracebackType
from typing import TYPE_CHECKING, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from worlds import Pose, RayHits

if TYPE_CHECKING:
    from worlds.facetable import FaceTable

__all__ = ["ClosedByWith", "Engine", "RayCaster", "table_of"]


class RayCaster(Protocol):
    """Casts rays at the surfaces of a world; the robot itself is invisible to them.

    One that knows the faces themselves has them as ``table``, see `table_of`.
    """

    def cast(
        self,
        origins_xy_m: NDArray[np.float64],
        directions_xy: NDArray[np.float64],
        range_max_m: NDArray[np.float64],
    ) -> RayHits:
        """Return the first surface within ``range_max_m`` of each of n rays.

        Parameters
        ----------
        origins_xy_m, directions_xy : ndarray, shape (n, 2)
            Where each ray begins, metres, and its unit direction.
        range_max_m : ndarray, shape (n,)
            How far each ray goes, metres, > 0.
        """


def table_of(rays: RayCaster) -> FaceTable | None:
    """Return the faces, as the only room of a table, that a ray caster knows; None if it does not.

    Faces need no rays: what is nearest in a cone follows from them in closed form.
    """
    table: FaceTable | None = getattr(rays, "table", None)
    return table


class Engine(RayCaster, Protocol):
    """A robot in a world: it drives, it collides, and rays can be cast from it."""

    @property
    def pose(self) -> Pose:
        """True pose of the robot."""

    @property
    def wheel_turns_rad(self) -> tuple[float, float]:
        """How far the left and right wheel have turned since the start, radians."""

    def advance(self, left_mps: float, right_mps: float, duration_s: float) -> bool:
        """Drive towards the given wheel speeds; return whether the robot touched something.

        Speeds are reached within the robot's limits (`sim.robot.kinematics.limited_speeds`).
        `duration_s` is a whole multiple of `sim.robot.amigobot.PHYSICS_DT_S`.
        """

    def close(self) -> None:
        """Release what the engine holds; closing twice is fine."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...


class ClosedByWith:
    """What is closed when the ``with`` that uses it ends."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Release what is held; closing twice is fine."""
        raise NotImplementedError
