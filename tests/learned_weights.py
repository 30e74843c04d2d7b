"""A small network of random weights, for tests that need one of any kind."""

import numpy as np

from sonarmap.learned.channels import CHANNELS
from sonarmap.learned.weights import Calibration, Layer, Weights

COUNT = len(CHANNELS)


def small_weights(rng, widths=(4, 6, 8), channels=COUNT):
    """Return weights as training would make them, rounded as files have them."""

    def layer(before, after):
        kernel = rng.normal(0, 1 / np.sqrt(9 * before), (after, 9 * before)).astype(np.float16)
        return Layer(kernel.astype(np.float32), rng.normal(0, 0.1, (after, 1)).astype(np.float32))

    def pair(before, after):
        return layer(before, after), layer(after, after)

    before = (channels, *widths[:-1])
    return Weights(
        widths,
        tuple(pair(n, m) for n, m in zip(before, widths, strict=True)),
        tuple(
            pair(deep + level, level)
            for level, deep in zip(widths[-2::-1], widths[:0:-1], strict=True)
        ),
        rng.normal(size=(2, widths[0])).astype(np.float32),
        rng.normal(size=(2, 1)).astype(np.float32),
        {0.5: Calibration(0.9, -0.8), 1.0: Calibration(0.95, 0.1), 2.0: Calibration(0.9, 0.5)},
        occupied_from=0.3,
        free_up_to=0.12,
        share=0.07,
        reading={"mean": np.zeros(3, np.float32)},
    )
