"""The volume of agreements: against both features laid together, and against plain torch."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from avsec_gym.perception.nn.correlation_volume import (
    correlation_volume,
    plain_correlation_volume,
)
from avsec_gym.perception.nn.cost_volume import sampled_volume

DISPARITIES = torch.tensor([[0.0, 1.5, 3.0, 6.0, 9.5], [2.0, 0.3, 6.7, 5.9, 7.0]])


def _features(*shape: int) -> Tensor:
    return torch.randn(*shape, dtype=torch.float64, generator=torch.Generator().manual_seed(0))


def test_agreement_is_the_mean_product_of_each_group() -> None:
    left, right = _features(2, 2, 6, 2, 7)
    volume = correlation_volume(left, right, DISPARITIES, 3)
    both = sampled_volume(left, right, DISPARITIES)
    products = both[:, :6] * both[:, 6:]
    expected = torch.stack([products[:, 2 * g : 2 * g + 2].mean(1) for g in range(3)], 1)
    torch.testing.assert_close(volume, expected)


def test_the_views_agree_best_on_the_plane_where_the_scene_is() -> None:
    texture = _features(1, 16, 4, 60)
    disparities = torch.tensor([[1.0, 2.5, 4.0, 5.5, 7.0]])
    left, right = texture[..., :40], texture[..., 4:44]  # left(x) = right(x - 4)
    volume = correlation_volume(left, right, disparities, 1)[0, 0]
    assert (volume[..., 8:].argmax(0) == 2).all()


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64, torch.bfloat16])
def test_kernels_and_plain_torch_agree_forth_and_back(dtype: torch.dtype) -> None:
    left, right = (half.to(dtype).requires_grad_() for half in _features(2, 2, 6, 2, 7))
    volume = correlation_volume(left, right, DISPARITIES, 2)
    assert volume.dtype == torch.promote_types(dtype, torch.float32)
    weights = _features(*volume.shape).to(volume.dtype)
    found = torch.autograd.grad((volume * weights).sum(), (left, right))
    plain = plain_correlation_volume(left.to(volume.dtype), right.to(volume.dtype), DISPARITIES, 2)
    expected = torch.autograd.grad((plain * weights).sum(), (left, right))
    torch.testing.assert_close(volume, plain)
    for one, other in zip(found, expected, strict=True):
        assert one.dtype == dtype
        torch.testing.assert_close(one, other)


def test_gradient_agrees_with_finite_differences() -> None:
    left, right = (half.requires_grad_() for half in _features(2, 1, 2, 2, 5))
    disparities = torch.tensor([[0.0, 1.3, 4.2]])
    assert torch.autograd.gradcheck(
        lambda a, b: correlation_volume(a, b, disparities, 1), (left, right)
    )
