"""`Rooms`: the rooms of many episodes in one table of faces."""

from __future__ import annotations

from worlds import World
from worlds.facetable import FaceTable, face_table

__all__ = ["Rooms"]


class Rooms:
    """Which room each robot is in, and the faces of all of them.

    Parameters
    ----------
    robots : int
        How many.
    """

    def __init__(self, robots: int) -> None:
        self._number_of: list[int | None] = [None] * robots
        self._worlds: list[World] = []
        self.table: FaceTable | None = None
        self.surfaces = 0

    def enter(self, row: int, world: World) -> int:
        """Put a robot into a room; return the room's number in the table.

        Numbers of rooms that are in use do not change.
        """
        # The room that it leaves may be replaced.
        self._number_of[row] = None
        number = self._number(world)
        self._number_of[row] = number
        return number

    def _number(self, world: World) -> int:
        """Return the number of a room, which joins the table if it is not there yet."""
        for number, known in enumerate(self._worlds):
            # Worlds that differ in their materials alone share their faces.
            if known.faces is world.faces:
                return number
        number = self._free_number()
        self._worlds[number : number + 1] = [world]
        self.surfaces = max(len(known.solids) for known in self._worlds)
        self.table = face_table(
            [
                (faces.segments_m, faces.circles_m, faces.surface)
                for faces in (known.faces for known in self._worlds)
            ]
        )
        return number

    def _free_number(self) -> int:
        # By number, not by the room itself: the rooms of a copy are other objects.
        for number in range(len(self._worlds)):
            if number not in self._number_of:
                return number
        return len(self._worlds)
