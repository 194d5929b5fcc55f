"""Which points of a cloud are near a place, and the features that they give it.

Features of points are a tensor (B, N, C), of their neighbours (B, M, K, C).
"""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from avsec_gym.frame import Points
from avsec_gym.kernels import kernel

_NO_DISTANCE = 1e-8


def ball_query(points: Tensor, centres: Tensor, radius: float, count: int) -> Tensor:
    """The first points, in their order, that are nearer to a centre than a radius.

    Args:
        points: The points of B clouds, shape (B, N, 3).
        centres: The centres of M balls in each, shape (B, M, 3).
        radius: The radius of the balls, metres.
        count: How many are taken; where there are fewer, the first is repeated; where there is
            none, all are 0.

    Returns:
        Indices, shape (B, M, count).
    """
    found = _in_balls(_places(points), _places(centres), np.float32(radius), count)
    return torch.from_numpy(found).to(points.device)


def three_nearest(points: Tensor, known: Tensor) -> tuple[Tensor, Tensor]:
    """The three known points that are nearest to each point.

    Args:
        points: The points, shape (B, N, 3).
        known: The known points, shape (B, M, 3), M at least 3.

    Returns:
        Distances in metres, nearest first, and indices, both of shape (B, N, 3).
    """
    squares, index = _nearest(_places(points), _places(known))
    distances = torch.from_numpy(squares).sqrt_()
    return distances.to(points.device), torch.from_numpy(index).to(points.device)


def gathered(features: Tensor, index: Tensor) -> Tensor:
    """The features of indexed points.

    Args:
        features: The features, shape (B, N, C).
        index: The indices, shape (B, ...).

    Returns:
        Shape (B, ..., C).
    """
    clouds, points, _ = features.shape
    first = points * torch.arange(clouds, device=index.device)
    rows = index + first.view(-1, *(1 for _ in index.shape[1:]))
    return functional.embedding(rows, features.flatten(0, 1))


def interpolated(features: Tensor, distances: Tensor, index: Tensor) -> Tensor:
    """The mean of neighbours, the nearer ones more: weights are inverse distances.

    Args:
        features: The features of known points, shape (B, M, C).
        distances: The distances to the neighbours, shape (B, N, K).
        index: The indices of the neighbours among the known points, shape (B, N, K).

    Returns:
        Shape (B, N, C).
    """
    weights = 1 / (distances + _NO_DISTANCE)
    weights = (weights / weights.sum(-1, keepdim=True)).to(features.dtype)
    return (gathered(features, index) * weights[..., None]).sum(-2)


def _places(points: Tensor) -> Points:
    places: Points = points.detach().float().cpu().contiguous().numpy()
    return places


@kernel(nogil=True)
def _in_balls(clouds: Points, centres: Points, radius: np.float32, count: int) -> NDArray[np.int64]:
    index = np.zeros((len(clouds), centres.shape[1], count), np.int64)
    for cloud in range(len(clouds)):
        points = clouds[cloud]
        for number in range(centres.shape[1]):
            x, y, z = centres[cloud, number]
            found = 0
            for i in range(len(points)):
                dx, dy, dz = points[i, 0] - x, points[i, 1] - y, points[i, 2] - z
                if dx * dx + dy * dy + dz * dz < radius * radius:
                    # The first fills all places, as in the original: what is left repeats it.
                    if found == 0:
                        index[cloud, number] = i
                    index[cloud, number, found] = i
                    found += 1
                    if found == count:
                        break
    return index


@kernel(nogil=True)
def _nearest(clouds: Points, known: Points) -> tuple[Points, NDArray[np.int64]]:
    squares = np.full((len(clouds), clouds.shape[1], 3), np.inf, np.float32)
    index = np.zeros(squares.shape, np.int64)
    for cloud in range(len(clouds)):
        for number in range(clouds.shape[1]):
            x, y, z = clouds[cloud, number]
            best, second, third = np.inf, np.inf, np.inf
            for i in range(known.shape[1]):
                dx, dy, dz = known[cloud, i, 0] - x, known[cloud, i, 1] - y, known[cloud, i, 2] - z
                square = dx * dx + dy * dy + dz * dz
                # Invariant: best <= second <= third, and the first of equals stands before.
                if square >= third:
                    continue
                rank = 2
                if square < best:
                    rank, third, second, best = 0, second, best, square
                elif square < second:
                    rank, third, second = 1, second, square
                else:
                    third = square
                for later in range(2, rank, -1):
                    index[cloud, number, later] = index[cloud, number, later - 1]
                index[cloud, number, rank] = i
            squares[cloud, number, 0] = best
            squares[cloud, number, 1] = second
            squares[cloud, number, 2] = third
    return squares, index
