"""Fans of rays that find the faces around sonars, and the sounds that come back from them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sim import echoing as e
from sim.engine import RayCaster
from sonarmap import LogTruth

if TYPE_CHECKING:
    from sim.physical import PhysicalSonar

__all__ = ["Fans", "no_sounds"]

# A ray that shall see a point sees it if its length agrees so well, metres.
_SAME_LENGTH_M = 1e-3
# Ends of faces are searched until they lie between rays so close, radians: 1.6 mm at 3 m; each
# search splits the gap into so many parts, because one large batch of rays costs less than many.
_END_RAD, _SPLIT = math.radians(0.03), 10

SOUND = np.dtype(
    [
        ("sent_s", np.float64),
        ("source", np.int16),
        ("listener", np.int16),
        ("way_m", np.float64),
        ("level_db", np.float64),
        ("surface", np.int32),
        ("incidence_rad", np.float64),
        ("bounces", np.int16),
    ]
)


def no_sounds(count: int = 0) -> NDArray[np.void]:
    """Return an empty table of sounds, or one with lines that stand for no sound."""
    sounds = np.zeros(count, SOUND)
    sounds["source"], sounds["surface"] = LogTruth.NO_SOURCE, -1
    sounds["incidence_rad"] = np.nan
    return sounds


@dataclass(frozen=True, slots=True, eq=False)
class _Leg:
    """Rays on one leg of their way and what they met, see `sim.echoing`."""

    fan: NDArray[np.int64]
    group: NDArray[np.int64]
    number: NDArray[np.int64]
    rays: NDArray[np.float64]
    length_m: NDArray[np.float64]
    normal: NDArray[np.float64]
    surface: NDArray[np.int32]
    piece: NDArray[np.int64]
    pieces: NDArray[np.float64]
    ends: NDArray[np.int64]


class Fans:
    """The fans of the sonars that fire together, followed from face to face."""

    def __init__(
        self,
        sonar: PhysicalSonar,
        caster: RayCaster,
        surfaces: tuple[NDArray[np.float64], ...],
        sonars: tuple[int, ...],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        *,
        alone: bool,
    ) -> None:
        self._sonar, self._caster, self._alone = sonar, caster, alone
        self._radius_m, self._reflect_db, self._floor_db = surfaces
        self._sonars = np.array(sonars, np.int64)
        self._all_xy_m, self._all_axis_rad = sensor_xy_m, axis_rad
        self._xy_m, self._axis_rad = sensor_xy_m[self._sonars], axis_rad[self._sonars]
        self._air, self._beam = sonar.air_table, sonar.beam_table
        self._angles = np.linspace(0, math.pi, self._beam.size)

    def sounds(self, time_s: float) -> NDArray[np.void]:
        """Return all that may be heard of this firing."""
        fan, number, rays = self._rays()
        group, reach_m = fan, self._first_reach_m(rays[:, e.RAY_THETA])
        found = []
        for mirrors in range(self._sonar.max_bounces + 1):
            leg = self._met(fan, group, number, rays, reach_m)
            if mirrors == 0:
                self._met_m = leg.length_m.reshape(len(self._sonars), -1)
            # Behind a mirror an end stays between its two rays: a second-order sound's small error.
            corners, edges = self._boundaries(leg, refined=mirrors == 0)
            values, index = self._of_faces(leg, corners, edges, mirrors)
            found.append((values, index, np.full(len(values), mirrors, np.int16)))
            if mirrors == self._sonar.max_bounces:
                break
            fan, group, number, rays = self._mirrored(leg)
            if fan.size == 0:
                break
            reach_m = self._sonar.reach_m - rays[:, e.RAY_WAY]
        values, index, bounces = (np.concatenate(column) for column in zip(*found, strict=True))
        free = self._are_free(values, index, bounces)
        values, index = values[free], index[free]
        sounds = np.empty(len(values), SOUND)
        sounds["sent_s"], sounds["source"] = time_s, self._sonars[index[:, 0]]
        sounds["listener"], sounds["surface"] = index[:, 1], index[:, 2]
        sounds["way_m"] = values[:, e.SOUND_WAY]
        sounds["level_db"] = values[:, e.SOUND_LEVEL]
        sounds["incidence_rad"] = values[:, e.SOUND_INCIDENCE]
        sounds["bounces"] = bounces[free]
        return sounds

    def truth(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the true ranges on the axes and in the nominal cones; +inf beyond the range."""
        ring, bearing = self._sonar.ring, self._sonar.bearing_rad
        met_m = np.where(self._met_m <= ring.range_max_m, self._met_m, np.inf)
        cone = np.abs(bearing) <= ring.half_angle_rad + 1e-9
        return met_m[:, bearing.size // 2], met_m[:, cone].min(axis=1)

    def _rays(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
        bearing = self._sonar.bearing_rad
        fan = np.repeat(np.arange(len(self._sonars)), bearing.size)
        number = np.tile(np.arange(bearing.size), len(self._sonars))
        return fan, number, self._departing(fan, np.tile(bearing, len(self._sonars)))

    def _departing(
        self, fan: NDArray[np.int64], bearing_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return rays that leave their transducers."""
        rays = np.zeros((fan.size, e.RAY_COLUMNS))
        angle = self._axis_rad[fan] + bearing_rad
        rays[:, e.RAY_THETA] = bearing_rad
        rays[:, [e.RAY_X, e.RAY_Y]] = rays[:, [e.RAY_IX, e.RAY_IY]] = self._xy_m[fan]
        rays[:, e.RAY_DX], rays[:, e.RAY_DY] = np.cos(angle), np.sin(angle)
        rays[:, e.RAY_SIGN] = 1.0
        return rays

    def _first_reach_m(self, bearing_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how far rays go: as far as they are heard, in the cone as the truth is asked."""
        sent_db = np.interp(np.abs(bearing_rad), self._angles, self._beam)
        far_m = self._sonar.reaches_m[np.clip(np.ceil(sent_db) + 100, 0, 100).astype(int)]
        ring = self._sonar.ring
        in_cone = np.abs(bearing_rad) <= ring.half_angle_rad + 1e-9
        return np.maximum(far_m, np.where(in_cone, ring.range_max_m, 0.1))

    def _met(
        self,
        fan: NDArray[np.int64],
        group: NDArray[np.int64],
        number: NDArray[np.int64],
        rays: NDArray[np.float64],
        reach_m: NDArray[np.float64],
    ) -> _Leg:
        """Return what rays meet, and the faces that this shows."""
        hits = self._caster.cast(
            rays[:, [e.RAY_X, e.RAY_Y]], rays[:, [e.RAY_DX, e.RAY_DY]], reach_m
        )
        normal = np.ascontiguousarray(hits.normal_xy)
        met = hits.distance_m, normal, hits.surface
        piece, pieces, ends = e.find_pieces(group, number, rays, *met, self._radius_m)
        return _Leg(fan, group, number, rays, *met, piece, pieces, ends)

    def _mirrored(self, leg: _Leg) -> tuple[NDArray[np.int64], ...]:
        """Return fan, group, number and table of the rays that go on."""
        on: tuple[NDArray[np.int64], ...] = e.mirrored_rays(
            leg.fan,
            leg.number,
            leg.rays,
            leg.length_m,
            leg.normal,
            leg.surface,
            leg.piece,
            self._radius_m,
            self._reflect_db,
            self._air,
            self._beam,
            self._sonar.reach_m,
        )
        return on

    def _boundaries(
        self, leg: _Leg, *, refined: bool
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return corners and edges; set the ends of the pieces."""
        fan, rays, surface, piece, pieces = leg.fan, leg.rays, leg.surface, leg.piece, leg.pieces
        corners, edges, open_ends = e.find_boundaries(
            leg.group,
            leg.number,
            rays,
            leg.length_m,
            surface,
            piece,
            pieces,
            leg.ends,
            self._radius_m,
            self._reflect_db,
            self._floor_db,
            self._air,
            self._beam,
            self._sonar.edge_db,
        )
        if not refined or not len(open_ends):
            return corners, edges
        near, far = open_ends.T
        inside, outside = rays[near, e.RAY_THETA], rays[far, e.RAY_THETA]
        face = np.repeat(pieces[piece[near]], _SPLIT - 1, axis=0)
        normal, point = face[:, [e.PIECE_NX, e.PIECE_NY]], face[:, [e.PIECE_X, e.PIECE_Y]]
        wanted = np.repeat(surface[near], _SPLIT - 1)
        is_flat = self._radius_m[wanted] == 0
        length_m = leg.length_m[near]
        shares, row = np.arange(_SPLIT) / _SPLIT, np.arange(near.size)
        widest = np.abs(outside - inside).max()
        for _ in range(math.ceil(math.log(widest / _END_RAD) / math.log(_SPLIT))):
            gap = outside - inside
            between = (inside[:, None] + gap[:, None] * shares[1:]).ravel()
            sent = self._departing(np.repeat(fan[near], _SPLIT - 1), between)
            origin, direction = sent[:, [e.RAY_X, e.RAY_Y]], sent[:, [e.RAY_DX, e.RAY_DY]]
            hits = self._caster.cast(origin, direction, np.full(len(sent), self._sonar.reach_m))
            on = hits.surface == wanted
            met_m = np.where(on, hits.distance_m, 0.0)
            off_m = ((origin + met_m[:, None] * direction - point) * normal).sum(axis=1)
            on &= ~is_flat | (np.abs(off_m) < 1e-4)
            # So many rays, from the inside on, still meet the face.
            last = np.cumprod(on.reshape(near.size, -1), axis=1).sum(axis=1)
            lengths_m = np.column_stack([length_m, met_m.reshape(near.size, -1)])
            length_m = lengths_m[row, last]
            inside, outside = inside + gap * last / _SPLIT, inside + gap * (last + 1) / _SPLIT
        after = far > near
        pieces[piece[near[after]], e.PIECE_HIGH] = inside[after]
        pieces[piece[near[~after]], e.PIECE_LOW] = inside[~after]
        sent = self._departing(fan[near], inside)
        ends = sent[:, [e.RAY_X, e.RAY_Y]] + length_m[:, None] * sent[:, [e.RAY_DX, e.RAY_DY]]
        # A pillar has no edge: its outline is where rays graze it.
        new = np.column_stack([near, ends])[self._radius_m[surface[near]] == 0]
        return corners, np.concatenate([edges, new])

    def _of_faces(
        self, leg: _Leg, corners: NDArray[np.float64], edges: NDArray[np.float64], mirrors: int
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Return the table of sounds, and of each its fan, listener and surface."""
        found: tuple[NDArray[np.float64], NDArray[np.int64]] = e.find_sounds(
            leg.fan,
            leg.rays,
            leg.surface,
            leg.piece,
            leg.pieces,
            leg.ends,
            corners,
            edges,
            self._radius_m,
            self._reflect_db,
            self._floor_db,
            self._air,
            self._beam,
            self._sonar.edge_db,
            self._sonar.reach_m,
            self._sonars,
            self._all_xy_m,
            self._all_axis_rad,
            # The foot of a face may lie between its last ray and the next one.
            6 * self._sonar.ray_step_rad,
            mirrors,
            self._alone,
            self._sonar.receiver.pulse_s * self._sonar.air.speed_mps / 2,
        )
        return found

    def _are_free(
        self,
        sounds: NDArray[np.float64],
        index: NDArray[np.int64],
        bounces: NDArray[np.int16],
    ) -> NDArray[np.bool_]:
        """Return which sounds have a free way, leg by leg, where rays have not seen it yet."""
        free = np.ones(len(sounds), bool)
        # Forth: along the bearing of departure, over as many mirrors, to the point. Back: from
        # the listener to the point, without mirrors.
        forth = np.flatnonzero(sounds[:, e.SOUND_SEEN] > 0)
        back = np.flatnonzero(~np.isnan(sounds[:, e.SOUND_BACK]))
        if not forth.size + back.size:
            return free
        departing = self._departing(index[forth, 0], sounds[forth, e.SOUND_THETA])
        listener, back_m = self._all_xy_m[index[back, 1]], sounds[back, e.SOUND_BACK]
        point = sounds[back][:, [e.SOUND_QX, e.SOUND_QY]]
        length_m = np.concatenate([sounds[forth, e.SOUND_SEEN], back_m])
        followed_m = self._followed(
            np.concatenate([departing[:, [e.RAY_X, e.RAY_Y]], listener]),
            np.concatenate(
                [departing[:, [e.RAY_DX, e.RAY_DY]], (point - listener) / back_m[:, None]]
            ),
            np.concatenate([bounces[forth], np.zeros(back.size, np.int16)]),
            length_m + 0.1,
        )
        blocked = np.abs(followed_m - length_m) >= _SAME_LENGTH_M
        free[np.concatenate([forth, back])[blocked]] = False
        return free

    def _followed(
        self,
        origin: NDArray[np.float64],
        direction: NDArray[np.float64],
        bounces: NDArray[np.int16],
        reach_m: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Return how far rays go until they meet something after so many mirrors."""
        length_m = np.zeros(bounces.size)
        on = np.arange(bounces.size)
        for mirrors in range(int(bounces.max()) + 1):
            hits = self._caster.cast(origin, direction, reach_m[on] - length_m[on])
            length_m[on] += hits.distance_m
            further = (bounces[on] > mirrors) & (length_m[on] < reach_m[on])
            on, normal = on[further], hits.normal_xy[further]
            if not on.size:
                break
            origin = origin[further] + hits.distance_m[further, None] * direction[further]
            origin = origin + 1e-6 * normal
            direction = direction[further]
            along = (direction * normal).sum(axis=1)[:, None]
            direction = direction - 2 * along * normal
        return length_m
