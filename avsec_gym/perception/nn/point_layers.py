"""PointNet++'s layers (Qi et al., NeurIPS 2017): fewer points that know more, and back to all.

Keys of the ``state_dict`` are those of github.com/sshaoshuai/Pointnet2.PyTorch; there, features
have their channels before the points, here, behind them: (B, N, C).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.nn.point_neighbours import (
    ball_query,
    gathered,
    interpolated,
    three_nearest,
)
from avsec_gym.perception.nn.point_sampling import farthest_points


class PointLayer(nn.Module):
    """One linear layer for all points alike: a convolution of size 1, as published.

    Args:
        inputs: The number of channels that it takes.
        outputs: The number of channels that it gives.
        dimensions: The number of dimensions of the original convolution, 1 or 2, for the shape of
            its weights.
        is_normalised: Whether it is normalised over the batch; there is no bias then.
        has_relu: Whether a ReLU stands at the end.
    """

    def __init__(
        self,
        inputs: int,
        outputs: int,
        *,
        dimensions: int = 2,
        is_normalised: bool = True,
        has_relu: bool = True,
    ) -> None:
        super().__init__()
        convolution = nn.Conv1d if dimensions == 1 else nn.Conv2d
        self.conv = convolution(inputs, outputs, 1, bias=not is_normalised)
        if is_normalised:
            self.bn = nn.Sequential()
            self.bn.add_module("bn", nn.BatchNorm1d(outputs))
        self._is_normalised, self._has_relu = is_normalised, has_relu
        nn.init.kaiming_normal_(self.conv.weight)
        if self.conv.bias is not None:
            nn.init.zeros_(self.conv.bias)

    def forward(self, features: Tensor) -> Tensor:
        """(..., inputs) to (..., outputs)."""
        result = functional.linear(features, self.conv.weight.flatten(1), self.conv.bias)
        if self._is_normalised:
            result = self.bn(result.flatten(0, -2)).view(result.shape)
        return functional.relu(result) if self._has_relu else result


class PointLayers(nn.Sequential):
    """Several, one after the other, channels given from the first inputs to the last outputs."""

    def __init__(self, channels: Sequence[int], *, is_normalised: bool = True) -> None:
        super().__init__()
        for number, (inputs, outputs) in enumerate(pairwise(channels)):
            self.add_module(
                f"layer{number}", PointLayer(inputs, outputs, is_normalised=is_normalised)
            )


class SetAbstraction(nn.Module):
    """A few points learn what is around them, at one scale or several.

    Args:
        inputs: Channels of the points' features, 0 without any.
        count: Points that remain, by `farthest_points`; None: all become one, at the origin.
        radii: The radii of the balls around them, metres, one for each scale.
        neighbours: Points looked at in each ball.
        channels: Outputs of the layers of each scale.
        is_normalised: Whether its layers are normalised, see `PointLayer`.
    """

    def __init__(
        self,
        inputs: int,
        count: int | None,
        radii: Sequence[float],
        neighbours: Sequence[int],
        channels: Sequence[Sequence[int]],
        *,
        is_normalised: bool = True,
    ) -> None:
        super().__init__()
        self.mlps = nn.ModuleList(
            PointLayers([inputs + 3, *outputs], is_normalised=is_normalised) for outputs in channels
        )
        self._count = count
        self._balls = tuple(zip(radii, neighbours, strict=True))

    def forward(self, points: Tensor, features: Tensor | None) -> tuple[Tensor, Tensor]:
        """The remaining points (B, count, 3), and what they know (B, count, channels).

        Args:
            points: The points, shape (B, N, 3).
            features: The features, shape (B, N, inputs).
        """
        if self._count is None:
            around = points if features is None else torch.cat([points, features], -1)
            known = [layers(around).amax(-2, keepdim=True) for layers in self.mlps]
            return points.new_zeros(len(points), 1, 3), torch.cat(known, -1)
        centres = gathered(points, farthest_points(points, self._count))
        known = []
        for layers, (radius, neighbours) in zip(self.mlps, self._balls, strict=True):
            index = ball_query(points, centres, radius, neighbours)
            around = gathered(points, index) - centres[:, :, None]
            if features is not None:
                around = torch.cat([around, gathered(features, index)], -1)
            known.append(layers(around).amax(-2))
        return centres, torch.cat(known, -1)


class FeaturePropagation(nn.Module):
    """Hands the features of few points on to many.

    Args:
        channels: The numbers of channels: of the few points' features and the many's together, and
            of the layers.
    """

    def __init__(self, channels: Sequence[int]) -> None:
        super().__init__()
        self.mlp = PointLayers(channels)

    def forward(
        self, points: Tensor, few: Tensor, features: Tensor | None, few_features: Tensor
    ) -> Tensor:
        """What the many then know, shape (B, N, channels).

        Args:
            points: The many, shape (B, N, 3).
            few: The few, shape (B, M, 3).
            features: The features of the many, if there are any, shape (B, N, C).
            few_features: The features of the few, shape (B, M, D).
        """
        handed_on = interpolated(few_features, *three_nearest(points, few))
        return self.mlp(handed_on if features is None else torch.cat([handed_on, features], -1))
