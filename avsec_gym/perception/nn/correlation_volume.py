"""A plane-sweep volume of agreements: how well both views match on each plane (Guo et al., 2019).

On a CPU numba kernels sum the products as they come.  In plain torch every plane is a tensor of its
own, whose gradients are filled, copied and added one by one: half of the time of a training step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avsec_gym.kernels import kernel

Values = NDArray[np.float32] | NDArray[np.float64]


def correlation_volume(left: Tensor, right: Tensor, disparities: Tensor, groups: int) -> Tensor:
    """Means of products of the left features with the right ones sampled at ``x - disparity``.

    Args:
        left: Features of the left image, shape (B, C, H, W).
        right: The same shape.
        disparities: The disparities of the D planes for each pair, pixels of the features, >= 0,
            shape (B, D); no gradient reaches them.
        groups: G groups of neighbouring channels, each of which gives one mean.

    Returns:
        Shape (B, G, D, H, W): linear between columns, zero outside of the right image; on a CPU
        float32 where halves come in.
    """
    if left.device.type == "cpu":
        kind = torch.promote_types(left.dtype, torch.float32)
        apply: Callable[..., Tensor] = _Correlation.apply
        return apply(left.to(kind), right.to(kind), disparities, groups)
    return plain_correlation_volume(left, right, disparities, groups)


def plain_correlation_volume(
    left: Tensor, right: Tensor, disparities: Tensor, groups: int
) -> Tensor:
    """The same in torch alone, on any device: all planes are sampled by one matrix product."""
    batch, channels, height, width = right.shape
    planes = disparities.shape[1]
    disparities = disparities.to(torch.promote_types(right.dtype, torch.float32))
    columns = torch.arange(width).to(disparities)
    # Where each column of each plane looks, and how much each column of the right features counts.
    places = (columns - disparities[..., None]).flatten(1)[:, None]
    shares = (1 - (columns[:, None] - places).abs()).clamp(min=0) * (places >= 0)
    sampled = right.reshape(batch, channels * height, width) @ shares.to(right)
    sampled = sampled.reshape(batch, channels, height, planes, width)
    products = (left[:, :, :, None] * sampled).reshape(batch, groups, -1, height, planes, width)
    return products.mean(2).transpose(2, 3).contiguous()


class _Correlation(torch.autograd.Function):
    @staticmethod
    def forward(
        context: Any, left: Tensor, right: Tensor, disparities: Tensor, groups: int
    ) -> Tensor:
        context.save_for_backward(left, right, disparities)
        context.groups = groups
        batch, _, height, width = left.shape
        volume = np.empty((batch, groups, disparities.shape[1], height, width), _array(left).dtype)
        _correlate(_array(left), _array(right), *_whole_and_part(disparities, left), volume)
        return torch.from_numpy(volume)

    @staticmethod
    def backward(context: Any, *gradients: Tensor) -> tuple[Tensor, Tensor, None, None]:
        left, right, disparities = context.saved_tensors
        to_left, to_right = np.zeros_like(_array(left)), np.zeros_like(_array(right))
        _correlate_back(
            _array(left),
            _array(right),
            *_whole_and_part(disparities, left),
            _array(gradients[0].to(left.dtype)),
            to_left,
            to_right,
        )
        return torch.from_numpy(to_left), torch.from_numpy(to_right), None, None


def _array(values: Tensor) -> Values:
    return np.ascontiguousarray(values.detach().numpy())


def _whole_and_part(disparities: Tensor, like: Tensor) -> tuple[NDArray[np.int64], Values]:
    """Columns by which the right features move, rounded up, and how much that was too far."""
    places = np.array(disparities.tolist())
    first = np.vectorize(math.ceil, otypes=[np.int64])(places)
    return first, (first - places).astype(_array(like).dtype)


@kernel(nogil=True)
def _correlate(
    left: Values, right: Values, first: NDArray[np.int64], part: Values, volume: Values
) -> None:
    """Fill the volume: column x of the left row meets columns x - first and the next one."""
    batch, channels, height, width = left.shape
    groups, planes = volume.shape[1], volume.shape[2]
    each = channels // groups
    scale = left.dtype.type(1.0 / each)
    for b in range(batch):
        for y in range(height):
            for d in range(planes):
                # Columns left of `start` would look beyond the right image: they stay 0.
                start, weight = first[b, d], part[b, d]
                for g in range(groups):
                    row = volume[b, g, d, y]
                    row[:] = 0
                    for c in range(g * each, (g + 1) * each):
                        one, other = left[b, c, y], right[b, c, y]
                        # Apart, since a whole disparity may have no column x - start + 1.
                        if weight > 0:
                            for x in range(start, width):
                                here = other[x - start]
                                row[x] += one[x] * (here + weight * (other[x - start + 1] - here))
                        else:
                            for x in range(start, width):
                                row[x] += one[x] * other[x - start]
                    for x in range(start, width):
                        row[x] *= scale


@kernel(nogil=True)
def _correlate_back(
    left: Values,
    right: Values,
    first: NDArray[np.int64],
    part: Values,
    volume: Values,
    to_left: Values,
    to_right: Values,
) -> None:
    """Add what a gradient of the volume is to both features.

    Invariant: at each plane d, both hold what they had and the sums over the planes before d, row
    by row; a part above 0 is of a plane whose `start` is 1 or more, so that all columns exist.
    """
    batch, channels, height, width = left.shape
    groups, planes = volume.shape[1], volume.shape[2]
    each = channels // groups
    scale = left.dtype.type(1.0 / each)
    one_whole = left.dtype.type(1.0)
    for b in range(batch):
        for y in range(height):
            for d in range(planes):
                start, weight = first[b, d], part[b, d]
                rest = one_whole - weight
                for g in range(groups):
                    row = volume[b, g, d, y]
                    for c in range(g * each, (g + 1) * each):
                        one, other = left[b, c, y], right[b, c, y]
                        back, other_back = to_left[b, c, y], to_right[b, c, y]
                        if weight > 0:
                            for x in range(start, width):
                                here = other[x - start]
                                sampled = here + weight * (other[x - start + 1] - here)
                                back[x] += scale * row[x] * sampled
                            # Two passes: no two columns of one pass meet at the same place.
                            for x in range(start, width):
                                other_back[x - start] += scale * rest * row[x] * one[x]
                            for x in range(start, width):
                                other_back[x - start + 1] += scale * weight * row[x] * one[x]
                        else:
                            for x in range(start, width):
                                back[x] += scale * row[x] * other[x - start]
                                other_back[x - start] += scale * row[x] * one[x]
