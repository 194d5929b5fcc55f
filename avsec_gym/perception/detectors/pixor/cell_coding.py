"""How a cell describes an object: six values beside a place, and back.

A *rectangle* is a row ``x, y, length, width, heading`` in the velodyne frame, as
`avsec_gym.box_overlap` takes it.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration


def encode(rectangles: Floats, corners: Floats, configuration: PixorConfiguration) -> Floats:
    """The values of cells.

    Args:
        rectangles: The rectangles, shape (N, 5).
        corners: x and y of the corner of each cell (see `PixorConfiguration.corners`), (N, 2).
        configuration: Mean and deviation.

    Returns:
        Normalised cosine and sine of the heading, x and y of the middle less the corner's,
        logarithms of width and length: shape (N, 6).
    """
    x, y, length, width, heading = rectangles.T
    values = np.stack(
        [
            np.cos(heading),
            np.sin(heading),
            x - corners[:, 0],
            y - corners[:, 1],
            np.log(width),
            np.log(length),
        ],
        axis=-1,
    )
    return np.asarray((values - configuration.mean) / configuration.deviation)


def decode(values: Floats, corners: Floats, configuration: PixorConfiguration) -> Floats:
    """The inverse of `encode`: rectangles, shape (N, 5)."""
    cosine, sine, dx, dy, width, length = (values * configuration.deviation + configuration.mean).T
    # No untrained network's size overflows, or becomes nothing.
    length, width = (np.exp(np.clip(size, -5.0, 5.0)) for size in (length, width))
    heading = np.arctan2(sine, cosine)
    return np.stack([corners[:, 0] + dx, corners[:, 1] + dy, length, width, heading], axis=-1)
