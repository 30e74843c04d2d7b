"""The receiver of a sonar: time-varied gain, threshold, what it makes of an echo."""

from __future__ import annotations

from dataclasses import dataclass

from sonarmap.errors import non_negative, positive, within

__all__ = ["Receiver"]


@dataclass(frozen=True, slots=True)
class Receiver:
    """How strong an echo must be, and when and how exactly it is read.

    Parameters
    ----------
    dynamic_range_db : float
        How far the echo of a perfect mirror, met head-on at 1 m in normal air, stands above the
        threshold, decibels, > 0. It decides which lobes of the beam are detected: one side lobe up
        to 18 or 20 degrees at 36 to 40 dB, two up to 30 at 48 dB, three up to 42 at 56 dB. The
        default is set so that a drive through the shipped `corridor` loses a third of its
        readings, as a real robot's log of such a corridor does (RoboND-OccupancyGridMapping).
    gain_share : float
        Share of the propagation loss, in decibels, that the time-varied gain takes back while the
        receiver waits, in [0, 1]. With 1 every range has the same dynamic range; with the default,
        assumed, a plane at 5 m is left with 40 of 48 dB.
    pulse_s : float
        Length of the pulse, seconds, > 0: 16 cycles of 49.4 kHz (Polaroid 6500). The envelope of
        an echo rises so long, so a weak one crosses the threshold late: by up to 56 mm.
    blanking_s : float
        Time after a firing in which the receiver is deaf, seconds, >= 0. Of an echo that still
        lasts then the range is that of the blanking's end. Default: 0.1 m, where ARIA's AmigoBot
        begins to measure; a Polaroid 6500 as sold has 2.38 ms.
    noise_std_m : float
        Standard deviation of the range of a strong echo, metres, >= 0. A real AmigoBot that stood
        still 2 m from a target: 1000 readings, 1.0 mm.
    weak_noise_std_m : float
        What is added, as an independent error, at the threshold itself, metres, >= 0; it falls
        with the level: jitter is noise by slope. Assumed.
    quantum_m : float
        Readings are whole multiples of it, metres, >= 0; 0 for none. ARIA speaks in millimetres.
    """

    dynamic_range_db: float = 48.0
    gain_share: float = 0.7
    pulse_s: float = 16 / 49_400
    blanking_s: float = 0.58e-3
    noise_std_m: float = 0.001
    weak_noise_std_m: float = 0.005
    quantum_m: float = 0.001

    def __post_init__(self) -> None:
        positive("dynamic_range_db", self.dynamic_range_db)
        within("gain_share", self.gain_share, 0.0, 1.0)
        positive("pulse_s", self.pulse_s)
        non_negative("blanking_s", self.blanking_s)
        non_negative("noise_std_m", self.noise_std_m)
        non_negative("weak_noise_std_m", self.weak_noise_std_m)
        non_negative("quantum_m", self.quantum_m)
