"""One fit of a path and its walls: echoes on walls, walls square to each other, likely errors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sonarmap.cores import one_blas_thread
from sonarmap.poses.echoes import UsedEchoes
from sonarmap.poses.path import CorrectedPath
from sonarmap.poses.walls import Walls, attributed

__all__ = ["fitted", "square_axis"]

_STEPS = 30
_LEAST_GAIN = 1e-3
# An echo counts as half of one: neighbours err alike (chosen on generated rooms).
_TEMPER = 0.5
# Walls of rooms mostly stand square to each other (Coughlan and Yuille 1999: a Manhattan world).
# By so much they do, radians; those that do not lose little by it: the loss is robust. A wall of
# so many echoes has half a vote. All chosen on generated rooms, a third of them not square.
_SQUARE_RAD = 0.006
_HALF_A_VOTE = 20.0
# So far off walls still have a say in which way is square, radians (assumed).
_ASKEW_RAD = 0.03

Array = NDArray[np.float64]


def fitted(
    echoes: UsedEchoes, path: CorrectedPath, parameters: Array, walls: Walls, sigma_m: float
) -> tuple[Array, Walls]:
    """Return parameters of the path, and those of the walls that have echoes, moved to agree.

    Parameters
    ----------
    echoes : UsedEchoes
        Of the drive.
    path : CorrectedPath
        Of the same drive.
    parameters : ndarray, shape (path.parameters,)
        Where the path begins.
    walls : ndarray, shape (walls, 2)
        See `find_walls`.
    sigma_m : float
        How far echoes lie off their walls, metres.
    """
    from scipy.optimize import least_squares  # heavy: loaded when poses are refined

    echo, wall = attributed(echoes.seen(path, parameters), walls, sigma_m)
    if not len(echo):
        return parameters, walls[:0]
    used, wall = np.unique(wall, return_inverse=True)
    agreement = _Agreement(echoes.some(echo), wall, path, sigma_m)
    axis_rad = square_axis(walls[used, 0], agreement.support)
    with one_blas_thread():
        found = least_squares(
            agreement.residuals,
            np.concatenate([parameters, walls[used].ravel(), [axis_rad]]),
            agreement.jacobian,
            loss=agreement.loss,  # type: ignore[arg-type]  # the stubs know but one shape
            max_nfev=_STEPS,
            ftol=_LEAST_GAIN,
            x_scale="jac",
        )
    m = path.parameters
    return found.x[:m], found.x[m:-1].reshape(-1, 2)


def square_axis(normal_rad: Array, support: Array) -> float:
    """Return the direction to which most of the walls stand square, radians.

    Parameters
    ----------
    normal_rad : ndarray, shape (walls,)
        Directions of their perpendiculars.
    support : ndarray, shape (walls,)
        How much each counts.
    """
    between_rad = 4 * (normal_rad[:, None] - normal_rad)
    askew_rad = (between_rad + np.pi) % (2 * np.pi) - np.pi
    agreed = support @ (1 / (1 + (askew_rad / 4 / _ASKEW_RAD) ** 2))
    return float(normal_rad[np.argmax(agreed)])


class _Agreement:
    """Residuals of n echoes, k walls and m parameters of the path, in this order.

    What is sought has the path's parameters first, then direction and distance of each wall, and at
    last the direction to which walls stand square.
    """

    def __init__(
        self, echoes: UsedEchoes, wall: NDArray[np.intp], path: CorrectedPath, sigma_m: float
    ) -> None:
        self._echoes, self._wall, self._path, self._sigma_m = echoes, wall, path, sigma_m
        self._n, self._k, self._m = len(wall), int(wall.max()) + 1, path.parameters
        self.support = np.zeros(self._k)
        """Echoes of each wall, shape (k,)."""
        np.add.at(self.support, wall, echoes.weight)
        votes = self.support / (self.support + _HALF_A_VOTE)
        self._weight = np.concatenate([_TEMPER * echoes.weight, votes])

    def residuals(self, x: Array) -> Array:
        """Return what would be 0 if all agreed, in units of what is likely."""
        parameters, normal_rad, distance_m, axis_rad = self._parts(x)
        seen, across_rad = self._echoes.seen(self._path, parameters), normal_rad[self._wall]
        x_m, y_m = seen.place_m.T
        off_m = np.cos(across_rad) * x_m + np.sin(across_rad) * y_m + seen.range_m
        off_m -= distance_m[self._wall]
        # 0 for walls along the axis and for walls across it.
        askew_rad = np.sin(4 * (normal_rad - axis_rad)) / 4
        return np.concatenate(
            [off_m / self._sigma_m, askew_rad / _SQUARE_RAD, self._path.prior @ parameters]
        )

    def jacobian(self, x: Array) -> Array:
        """Return the derivatives of the residuals, shape (n + k + m, m + 2 k + 1)."""
        n, k, m = self._n, self._k, self._m
        parameters, normal_rad, _, axis_rad = self._parts(x)
        rows, across_rad = self._echoes.rows, normal_rad[self._wall]
        seen = self._echoes.seen(self._path, parameters)
        moves, turns = self._path.derivatives(parameters, rows)
        arm_x_m, arm_y_m = (seen.place_m - self._path.poses(parameters)[0][rows]).T
        cos, sin = np.cos(across_rad), np.sin(across_rad)
        rates = np.zeros((n + k + m, len(x)))
        rates[:n, :m] = cos[:, None] * moves[:, 0] + sin[:, None] * moves[:, 1]
        rates[:n, :m] += (sin * arm_x_m - cos * arm_y_m)[:, None] * turns
        echo, wall = np.arange(n), np.arange(k)
        rates[echo, m + 2 * self._wall] = cos * seen.place_m[:, 1] - sin * seen.place_m[:, 0]
        rates[echo, m + 2 * self._wall + 1] = -1.0
        rates[:n] /= self._sigma_m
        turning = np.cos(4 * (normal_rad - axis_rad)) / _SQUARE_RAD
        rates[n + wall, m + 2 * wall] = turning
        rates[n + wall, -1] = -turning
        rates[n + k :, :m] = self._path.prior
        return rates

    def loss(self, squared: Array) -> Array:
        """Cauchy's for echoes and walls, of which some agree with nothing; the prior as it is."""
        robust = self._n + self._k
        told_of = np.zeros((3, len(squared)))
        told_of[0, robust:], told_of[1, robust:] = squared[robust:], 1.0
        one_more = 1 + squared[:robust]
        told_of[:, :robust] = [np.log(one_more), 1 / one_more, -1 / one_more**2]
        told_of[:, :robust] *= self._weight
        return told_of

    def _parts(self, x: Array) -> tuple[Array, Array, Array, float]:
        m = self._m
        return x[:m], x[m:-1:2], x[m + 1 : -1 : 2], float(x[-1])
