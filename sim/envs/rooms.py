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
        self._of_robot: list[World | None] = [None] * robots
        self._worlds: list[World] = []
        self.table: FaceTable | None = None
        self.surfaces = 0

    def enter(self, row: int, world: World) -> int:
        """Put a robot into a room; return the room's number in the table.

        Numbers of rooms that are in use do not change.
        """
        self._of_robot[row] = world
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
        for number, known in enumerate(self._worlds):
            if not any(used and known.faces is used.faces for used in self._of_robot):
                return number
        return len(self._worlds)
