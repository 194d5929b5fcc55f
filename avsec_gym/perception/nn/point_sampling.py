"""A few points that stand for many: farthest point sampling (Eldar et al., 1997)."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avsec_gym.frame import Points
from avsec_gym.kernels import kernel


def farthest_points(points: Tensor, count: int) -> Tensor:
    """Points spread as evenly as can be: each is the farthest from those before it.

    Args:
        points: The points of B clouds, metres, shape (B, N, 3).
        count: How many of each; at most N are different.

    Returns:
        Indices, the first of each cloud 0, shape (B, count), on the points' device.  Of points
        equally far, the first is taken.

    Example:
        >>> farthest_points(torch.tensor([[[0.0, 0, 0], [1, 0, 0], [9, 0, 0]]]), 2)
        tensor([[0, 2]])
    """
    places = points.detach().float().cpu().contiguous().numpy()
    return torch.from_numpy(_farthest(places, count)).to(points.device)


@kernel(nogil=True)
def _farthest(clouds: Points, count: int) -> NDArray[np.int64]:
    chosen = np.zeros((len(clouds), count), np.int64)
    for cloud in range(len(clouds)):
        x, y, z = clouds[cloud, :, 0].copy(), clouds[cloud, :, 1].copy(), clouds[cloud, :, 2].copy()
        # Invariant: `nearest` is each point's squared distance to the nearest of those chosen.
        nearest = np.full(len(x), np.inf, np.float32)
        last = 0
        for number in range(1, count):
            x_last, y_last, z_last = x[last], y[last], z[last]
            for i in range(len(x)):  # Apart from the search, so that it is vectorised.
                square = (x[i] - x_last) ** 2 + (y[i] - y_last) ** 2 + (z[i] - z_last) ** 2
                nearest[i] = min(nearest[i], square)
            chosen[cloud, number] = last = int(np.argmax(nearest))
    return chosen
