"""`Faces`: the surfaces of a room as line segments and circles, and rays cast at them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from shapely import Polygon

from sonarmap.errors import InputError
from worlds.rays import RayHits

if TYPE_CHECKING:
    from worlds.facetable import FaceTable

__all__ = ["Faces"]


@dataclass(frozen=True, eq=False)
class Faces:
    """Segments and circles, each with the index of the surface it belongs to.

    Parameters
    ----------
    segments_m : ndarray, shape (n, 4)
        (x0, y0, x1, y1) of each segment, metres.
    segment_surface : ndarray of int32, shape (n,)
        Index of its surface in `surface_names`.
    circles_m : ndarray, shape (m, 3)
        (x, y, radius) of each circle, metres.
    circle_surface : ndarray of int32, shape (m,)
        Index of its surface in `surface_names`.
    surface_names : tuple of str
        One name a surface. In a world, surface i is solid i.
    """

    segments_m: NDArray[np.float64]
    segment_surface: NDArray[np.int32]
    circles_m: NDArray[np.float64]
    circle_surface: NDArray[np.int32]
    surface_names: tuple[str, ...]

    def __post_init__(self) -> None:
        for column in ("segments_m", "segment_surface", "circles_m", "circle_surface"):
            getattr(self, column).flags.writeable = False

    @classmethod
    def of(cls, solids: Iterable[tuple[Polygon, tuple[float, float, float] | None, str]]) -> Faces:
        """Return the faces of solids given as (outline, circle or None, name)."""
        segments, circles, names = [], [], []
        segment_surface, circle_surface = [], []
        for surface, (outline, circle, name) in enumerate(solids):
            names.append(name)
            if circle is not None:
                circles.append(circle)
                circle_surface.append(surface)
                continue
            for ring in (outline.exterior, *outline.interiors):
                xy = np.asarray(ring.coords)[:, :2]
                segments.append(np.hstack([xy[:-1], xy[1:]]))
                segment_surface += [surface] * (len(xy) - 1)
        return cls(
            np.ascontiguousarray(np.vstack([np.empty((0, 4)), *segments])),
            np.array(segment_surface, dtype=np.int32),
            np.array(circles, dtype=float).reshape(-1, 3),
            np.array(circle_surface, dtype=np.int32),
            tuple(names),
        )

    @property
    def surface(self) -> NDArray[np.int32]:
        """Index of the surface of each face, segments first, then circles."""
        return np.concatenate([self.segment_surface, self.circle_surface])

    @cached_property
    def table(self) -> FaceTable:
        """The faces as compiled code takes them, metres."""
        return self.table_in_cells((0.0, 0.0), 1.0)

    def table_in_cells(self, origin_xy_m: tuple[float, float], cell_m: float) -> FaceTable:
        """Return the table with lengths in cells of a grid instead of metres."""
        from worlds.facetable import face_table  # numba is heavy: loaded when rays are cast

        x_m, y_m = origin_xy_m
        segments = (self.segments_m - (x_m, y_m, x_m, y_m)) / cell_m
        circles = (self.circles_m - (x_m, y_m, 0.0)) / cell_m
        return face_table([(segments, circles, self.surface)])

    def cast(
        self, origins_xy_m: ArrayLike, directions_xy: ArrayLike, range_max_m: ArrayLike
    ) -> RayHits:
        """Return the first surface that each ray meets.

        Parameters
        ----------
        origins_xy_m : array_like, shape (n, 2)
            Where the rays begin, metres.
        directions_xy : array_like, shape (n, 2)
            Unit vectors along the rays.
        range_max_m : float or array_like, shape (n,)
            Length of the rays, metres; a surface at exactly this distance is met.

        Returns
        -------
        RayHits
            One row a ray. A surface within 1 nm of the origin does not count, so that a ray
            may begin on the surface that mirrored it.

        Raises
        ------
        InputError
            If shapes disagree, a number is not finite or a direction is no unit vector.
        """
        origins = _vectors("origins_xy_m", origins_xy_m)
        directions = _vectors("directions_xy", directions_xy)
        if len(origins) != len(directions):
            raise InputError(
                f"origins_xy_m and directions_xy must have one row a ray, "
                f"got {len(origins)} and {len(directions)}"
            )
        length = np.hypot(directions[:, 0], directions[:, 1])
        if (np.abs(length - 1) > 1e-6).any():
            worst = length[np.argmax(np.abs(length - 1))]
            raise InputError(f"directions_xy must be unit vectors, got one of length {worst:g}")
        try:
            reach = np.broadcast_to(np.asarray(range_max_m, float), len(origins)).copy()
        except ValueError:
            raise InputError(
                f"range_max_m must be a number or one a ray ({len(origins)}), "
                f"got shape {np.shape(range_max_m)}"
            ) from None
        if not (reach >= 0).all():
            raise InputError("range_max_m must be >= 0")
        from worlds.raycast import cast_rays  # numba is heavy: loaded when rays are cast

        return RayHits(*cast_rays(self.table, 0, origins, directions, reach))


def _vectors(name: str, values: ArrayLike) -> NDArray[np.float64]:
    vectors = np.ascontiguousarray(values, dtype=float)
    if vectors.ndim != 2 or vectors.shape[1] != 2:
        raise InputError(f"{name} must have shape (n, 2), got {vectors.shape}")
    if not np.isfinite(vectors).all():
        raise InputError(f"{name} must be finite numbers")
    return vectors
