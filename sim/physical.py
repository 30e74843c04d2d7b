"""The physical sonar: beam, mirror echoes, scattering, threshold, and the sound of the others.

What comes back is decided by geometry and level: a flat face and a right-angled hollow corner send
the sound of an image source, a pillar a share of it, an edge little, and a rough face scatters
from wherever the beam meets it. What is heard is the first sound that crosses the threshold.

A ray-following sonar in the line of Wilkes, Dudek, Jenkin and Milios, "Modelling sonar range
sensors" (SPIE 1388, 1990), with the acoustic mirrors of Kuc and Siegel (IEEE Transactions on
Pattern Analysis and Machine Intelligence 9(6), 1987). Rays find the faces; distances come from
mirror images, so they are exact for flat faces and do not depend on the number of rays.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from sim import echoing as e
from sim.acoustics import Ears, Echoes, cause_of
from sim.air import Air
from sim.beacon import Beacon
from sim.engine import RayCaster
from sim.firing import Firing, InTurn
from sim.piston import Piston
from sim.receiver import Receiver
from sonarmap import Cause, InputError, LogTruth, SonarRing
from sonarmap.errors import finite, positive
from worlds import World

__all__ = ["PhysicalSonar"]

# A ray that shall see a point sees it if its length agrees so well, metres.
_SAME_LENGTH_M = 1e-3
# Ends of faces are searched until they lie between rays so close, radians: 1.6 mm at 3 m; each
# search splits the gap into so many parts, because one large batch of rays costs less than many.
_END_RAD, _SPLIT = math.radians(0.03), 10
# So far off the axis faces are looked for that the sound of another sonar may come by. Assumed.
_WIDE_RAD = math.radians(45)


@dataclass(frozen=True)
class PhysicalSonar:
    """A ring of sonars that behave like sonars.

    Parameters
    ----------
    name : str
        Name of the preset.
    ring : SonarRing
        Places, nominal cone (for the truths on axis and cone only), nearest and farthest range.
    firing : Firing
        When the sonars fire.
    piston : Piston
        Beam of the transducers.
    receiver : Receiver
        Threshold, gain, pulse, noise.
    air : Air
        The air that there is.
    assumed_air : Air
        The air for which the robot turns times into ranges.
    max_bounces : int
        Over how many mirroring faces a sound is followed before the face that turns it, >= 0.
    edge_db : float
        Level of an edge at 1 m against a plane at 1 m, decibels, <= 0; the level falls with
        1 / r^2 where a plane's falls with 1 / r. -37 dB: Keller's diffraction by a right-angled
        wedge, seen head-on, at 49.4 kHz (Journal of the Optical Society of America 52, 1962).
    ray_step_rad : float
        Angle between the rays of a fan, at most, radians, > 0. What is narrower than the gap
        between two rays may be missed; ranges do not depend on it.
    beacons : tuple of Beacon
        Sources of sound besides the robot's own.
    sound_life_s : float
        A sound is forgotten this long after it was sent, seconds, > 0. Default: two slots of
        40 ms, so that a sonar hears what the one before it sent.
    """

    name: str
    ring: SonarRing
    firing: Firing = field(default_factory=InTurn)
    piston: Piston = field(default_factory=Piston)
    receiver: Receiver = field(default_factory=Receiver)
    air: Air = field(default_factory=Air)
    assumed_air: Air = field(default_factory=Air)
    max_bounces: int = 1
    edge_db: float = -37.0
    ray_step_rad: float = math.radians(1.0)
    sound_life_s: float = 0.080
    beacons: tuple[Beacon, ...] = ()

    def __post_init__(self) -> None:
        self.firing.check(len(self.ring))
        if self.max_bounces < 0:
            raise InputError(f"max_bounces must be >= 0, got {self.max_bounces!r}")
        if finite("edge_db", self.edge_db) > 0:
            raise InputError(f"edge_db must be <= 0, got {self.edge_db!r}")
        positive("ray_step_rad", self.ray_step_rad)
        positive("sound_life_s", self.sound_life_s)

    def replace(self, **changes: object) -> PhysicalSonar:
        """Return this sonar with some fields replaced."""
        return replace(self, **changes)  # type: ignore[arg-type]

    def ears(self, rays: RayCaster, world: World, rng: np.random.Generator) -> Ears:
        """Return the sonars of one drive, see `sim.acoustics.Sonar`."""
        return _PhysicalEars(self, rays, world, rng)

    def listen(
        self,
        rays: RayCaster,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Echoes:
        """Fire k transducers that do not hear each other, see `sim.acoustics.Sonar`."""
        ears = _PhysicalEars(self, rays, world, rng, alone=True)
        ears.fire(0.0, tuple(range(len(axis_rad))), sensor_xy_m, np.asarray(axis_rad))
        return ears.hear()

    @property
    def window_s(self) -> float:
        """How long a sonar listens after its firing, seconds."""
        longest = 2 * self.ring.range_max_m / self.assumed_air.speed_mps
        return min(longest, self.firing.listening_s)

    @cached_property
    def reach_m(self) -> float:
        """Half of the longest way on which any sound is still heard, metres."""
        return float(self._reaches_m[-1])

    @cached_property
    def _reaches_m(self) -> NDArray[np.float64]:
        """How far sound reaches that is sent so many whole decibels below the axis, rising.

        Element 0 stands for -100 dB, element 100 for the axis.
        """
        half_m = np.linspace(0.02, self.air.speed_mps * self._heard_for_s / 2, 500)
        best_db = np.array([e.best_db(self._air, 2 * half) for half in half_m])
        loud = best_db[:, None] > np.arange(100, -1, -1)
        return np.where(loud.any(axis=0), half_m[len(half_m) - 1 - loud[::-1].argmax(axis=0)], 0.02)

    @cached_property
    def _heard_for_s(self) -> float:
        """How long after it was sent any sonar may still listen for a sound, seconds."""
        starts_s = [
            scan * self.firing.period_s + slot.offset_s
            for scan in (0, 1, 2, 3)
            for slot in self.firing.slots(scan, len(self.ring))
        ]
        waits_s = np.subtract.outer(starts_s, starts_s)
        last_s = waits_s[(waits_s >= 0) & (waits_s < self.sound_life_s)].max()
        return float(min(last_s + self.window_s, self.sound_life_s))

    @cached_property
    def _air(self) -> NDArray[np.float64]:
        """What the compiled steps need of air and receiver, see `sim.echoing.gain_db`."""
        nominal, tone = Air(), self.piston.frequency_hz
        slots = (self.firing.slots(scan, len(self.ring)) for scan in (0, 1))
        ahead_s = max(scan[-1].offset_s for scan in slots) if self._overlapping else 0.0
        return np.array(
            [
                self.air.speed_mps,
                self.air.absorption_db_per_m(tone),
                self.receiver.dynamic_range_db,
                self.receiver.gain_share,
                nominal.speed_mps,
                nominal.absorption_db_per_m(tone),
                self.window_s,
                ahead_s,
            ]
        )

    @cached_property
    def _overlapping(self) -> bool:
        """Whether a sonar listens while another one's sound is fresh."""
        for scan in (0, 1):
            slots = self.firing.slots(scan, len(self.ring))
            gaps_s = np.diff([slot.offset_s for slot in slots])
            if len(slots[0].sonars) > 1 or (gaps_s < self.window_s).any():
                return True
        return False

    @cached_property
    def _beam(self) -> NDArray[np.float64]:
        """One-way level at even steps of 0.02 degrees from 0 to 180."""
        return self.piston.level_db(np.linspace(0, math.pi, 9001))

    @cached_property
    def _bearing_rad(self) -> NDArray[np.float64]:
        """Bearings of a fan, the cone's edges and the axis among them.

        Dense in the main lobe; wider where only side lobes reach, which hear no small things; and
        as far out as the sound of another sonar may come from, by large faces.
        """
        half = self.ring.half_angle_rad
        # Near targets are the loudest.
        loudest_db = e.best_db(self._air, 2 * max(self.ring.range_min_m, 0.05))
        reach = min(max(self.piston.reach_rad(loudest_db), half), math.pi / 2)
        lobe = min(self.piston.null_rad, reach)
        stops = sorted({lobe, half, reach})
        if self._overlapping and reach < _WIDE_RAD:
            stops.append(_WIDE_RAD)
        side, last = [0.0], 0.0
        for stop in stops:
            step = self.ray_step_rad * (1 if stop <= lobe else 3 if stop <= reach else 5)
            count = math.ceil((stop - last) / step - 1e-9)
            side += [last + (stop - last) * k / count for k in range(1, count + 1)]
            last = stop
        return np.array([-bearing for bearing in side[:0:-1]] + side)


class _PhysicalEars:
    """The sonars of one drive, with the sounds that are under way."""

    def __init__(
        self,
        sonar: PhysicalSonar,
        rays: RayCaster,
        world: World,
        rng: np.random.Generator,
        *,
        alone: bool = False,
    ) -> None:
        self._sonar, self._rays, self._rng = sonar, rays, rng
        self._alone = alone
        # One entry more: surface -1, none, is the last.
        self._roughness_m = np.append(world.roughness_m, 0.0)
        with np.errstate(divide="ignore"):
            reflect_db = 20 * np.log10(np.maximum(world.reflectivity, 1e-10))
        self._surfaces = (
            np.append(world.radius_m, 0.0),
            np.append(reflect_db, 0.0),
            np.append(world.diffuse_floor_db, 0.0),
        )
        self._fired: list[tuple[float, int, float, float]] = []
        self._sounds = _no_sounds()

    def fire(
        self,
        time_s: float,
        sonars: tuple[int, ...],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> None:
        fans = _Fans(
            self._sonar,
            self._rays,
            self._surfaces,
            sonars,
            sensor_xy_m,
            axis_rad,
            alone=self._alone,
        )
        sounds = fans.sounds(time_s)
        axis_range_m, cone_range_m = fans.truth()
        outside = self._from_beacons(time_s, np.array(sonars), sensor_xy_m, axis_rad)
        self._sounds = np.concatenate([self._sounds, sounds, *outside])
        self._fired += [
            (time_s, sonar, axis_range_m[k], cone_range_m[k]) for k, sonar in enumerate(sonars)
        ]

    def hear(self) -> Echoes:
        sonar, receiver, sounds = self._sonar, self._sonar.receiver, self._sounds
        fired_s, number, axis_range_m, cone_range_m = np.array(self._fired).T
        number = number.astype(np.int64)
        heard, time_s, over_db = e.first_crossings(
            fired_s,
            number,
            sonar.window_s,
            sounds["sent_s"],
            sounds["source"],
            sounds["listener"],
            sounds["way_m"],
            sounds["level_db"],
            sonar.sound_life_s,
            sonar._air,
            receiver.pulse_s,
            receiver.blanking_s,
        )
        silent = heard < 0
        # What nobody heard takes a line of its own, the last.
        best = np.append(sounds, _no_sounds(1))[heard]
        cause = cause_of(
            np.where(silent, np.inf, best["way_m"] / 2), best["bounces"], axis_range_m, cone_range_m
        )
        others = (best["source"] != number) | (best["sent_s"] != fired_s)
        cause[others & ~silent] = Cause.CROSSTALK
        range_m = sonar.assumed_air.speed_mps * time_s / 2
        self._fired = []
        # Later firings may still hear what was sent a moment ago.
        self._sounds = sounds[sounds["sent_s"] + sonar.sound_life_s > fired_s[-1]]
        return Echoes(
            range_m=self._measured(range_m, over_db, self._roughness_m[best["surface"]]),
            axis_range_m=axis_range_m,
            cone_range_m=cone_range_m,
            cause=cause,
            surface=best["surface"],
            incidence_rad=best["incidence_rad"],
            bounces=best["bounces"],
            source=best["source"],
            level_db=over_db,
        )

    def _from_beacons(
        self,
        time_s: float,
        sonars: NDArray[np.int64],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> list[NDArray[np.void]]:
        """Return the beacons' pulses that may reach, straight, the sonars that listen now."""
        sonar, found = self._sonar, []
        for beacon in sonar.beacons:
            offset = np.array([beacon.x_m, beacon.y_m]) - sensor_xy_m[sonars]
            way_m = np.maximum(np.hypot(offset[:, 0], offset[:, 1]), 1e-6)
            hits = self._rays.cast(sensor_xy_m[sonars], offset / way_m[:, None], way_m)
            bearing = np.arctan2(offset[:, 1], offset[:, 0]) - axis_rad[sonars]
            received_db = sonar.piston.level_db(np.remainder(bearing + np.pi, 2 * np.pi) - np.pi)
            for k in np.flatnonzero(hits.surface < 0):
                travel_s = way_m[k] / sonar.air.speed_mps
                pulses_s = beacon.pulses_s(time_s - travel_s, time_s - travel_s + sonar.window_s)
                sounds = _no_sounds(pulses_s.size)
                sounds["sent_s"], sounds["source"] = pulses_s, LogTruth.OUTSIDE_SOURCE
                sounds["listener"], sounds["way_m"] = sonars[k], way_m[k]
                sounds["level_db"] = (
                    e.way_db(sonar._air, way_m[k]) + received_db[k] + beacon.level_db
                )
                found.append(sounds)
        return found

    def _measured(
        self,
        range_m: NDArray[np.float64],
        over_db: NDArray[np.float64],
        roughness_m: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        receiver, ring = self._sonar.receiver, self._sonar.ring
        jitter_m = receiver.weak_noise_std_m * 10 ** (-np.nan_to_num(over_db) / 20)
        std_m = np.sqrt(receiver.noise_std_m**2 + jitter_m**2 + roughness_m**2)
        reading = range_m + self._rng.normal(0.0, 1.0, range_m.size) * std_m
        if receiver.quantum_m > 0:
            reading = np.round(reading / receiver.quantum_m) * receiver.quantum_m
        # Noise alone must not turn an echo at the very end of the range into silence.
        reading = np.where(np.isfinite(range_m), np.minimum(reading, ring.range_max_m), np.inf)
        return np.where(reading < ring.range_min_m, -np.inf, reading)


_SOUND = np.dtype(
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


def _no_sounds(count: int = 0) -> NDArray[np.void]:
    """Return an empty table of sounds, or one with lines that stand for no sound."""
    sounds = np.zeros(count, _SOUND)
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


class _Fans:
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
        self._air, self._beam = sonar._air, sonar._beam
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
        sounds = np.empty(len(values), _SOUND)
        sounds["sent_s"], sounds["source"] = time_s, self._sonars[index[:, 0]]
        sounds["listener"], sounds["surface"] = index[:, 1], index[:, 2]
        sounds["way_m"] = values[:, e.SOUND_WAY]
        sounds["level_db"] = values[:, e.SOUND_LEVEL]
        sounds["incidence_rad"] = values[:, e.SOUND_INCIDENCE]
        sounds["bounces"] = bounces[free]
        return sounds

    def truth(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the true ranges on the axes and in the nominal cones; +inf beyond the range."""
        ring, bearing = self._sonar.ring, self._sonar._bearing_rad
        met_m = np.where(self._met_m <= ring.range_max_m, self._met_m, np.inf)
        cone = np.abs(bearing) <= ring.half_angle_rad + 1e-9
        return met_m[:, bearing.size // 2], met_m[:, cone].min(axis=1)

    def _rays(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
        bearing = self._sonar._bearing_rad
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
        far_m = self._sonar._reaches_m[np.clip(np.ceil(sent_db) + 100, 0, 100).astype(int)]
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
