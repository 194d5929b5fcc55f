"""ROI align against plain loops over samples, known images and finite differences."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Tensor

from avsec_gym.perception.nn.roi_align import SamplePlaces, roi_align

SCALES = (0.5, 0.25)


def _bilinear(features: Tensor, v: float, u: float) -> Tensor:
    """Between the four cells around a point, which lies within the map."""
    height, width = features.shape[1:]
    top, left = min(int(v), max(height - 2, 0)), min(int(u), max(width - 2, 0))
    total = torch.zeros(len(features), dtype=features.dtype)
    for row in (top, min(top + 1, height - 1)):
        for column in (left, min(left + 1, width - 1)):
            total += features[:, row, column] * (1 - abs(v - row)) * (1 - abs(u - column))
    return total


def _by_loops(features: Tensor, box: list[float], bins: int, scale: float, ratio: int) -> Tensor:
    """Branch 1.0: samples within the bins, one cell beyond the map belongs to its edge."""
    height, width = features.shape[1:]
    x1, y1, x2, y2 = (value * scale for value in box)
    bin_width, bin_height = max(x2 - x1, 1.0) / bins, max(y2 - y1, 1.0) / bins
    across, down = ratio or math.ceil(bin_width), ratio or math.ceil(bin_height)
    output = torch.zeros(len(features), bins, bins, dtype=features.dtype)
    for p in range(bins):
        for q in range(bins):
            for i in range(down):
                for j in range(across):
                    v = y1 + (p + (i + 0.5) / down) * bin_height
                    u = x1 + (q + (j + 0.5) / across) * bin_width
                    if -1 <= v <= height and -1 <= u <= width:
                        v, u = min(max(v, 0), height - 1), min(max(u, 0), width - 1)
                        output[:, p, q] += _bilinear(features, v, u) / (across * down)
    return output


def _master_by_loops(features: Tensor, box: list[float], bins: int, scale: float) -> Tensor:
    """Branch master: points of a grid, zero outside, averaged two by two."""
    height, width = features.shape[1:]
    x1, y1, x2, y2 = (value * scale for value in box)
    points = torch.zeros(len(features), bins + 1, bins + 1, dtype=features.dtype)
    for p in range(bins + 1):
        for q in range(bins + 1):
            v, u = y1 + p * (y2 - y1 + 1) / bins, x1 + q * (x2 - x1 + 1) / bins
            if 0 <= v <= height - 1 and 0 <= u <= width - 1:
                points[:, p, q] = _bilinear(features, v, u)
    return torch.nn.functional.avg_pool2d(points, 2, stride=1)


@pytest.fixture
def levels() -> list[Tensor]:
    generator = torch.Generator().manual_seed(0)
    shapes = [(2, 3, 20, 30), (2, 3, 10, 15)]
    return [torch.randn(shape, generator=generator, dtype=torch.float64) for shape in shapes]


BOXES = [
    [3.0, 4.0, 21.0, 17.0],  # within
    [0.0, 0.0, 59.0, 39.0],  # all of the image
    [-6.0, 30.0, 9.0, 48.0],  # beyond two sides
    [40.0, 10.0, 40.5, 35.0],  # narrower than a cell
    [2.0, 20.0, 58.0, 23.0],  # samples differ between the axes
    [0.0, 0.0, 0.0, 0.0],  # what proposals are filled up with
]


@pytest.mark.parametrize("ratio", [0, 1, 2])
def test_every_box_is_pooled_from_its_own_image_and_level(levels: list[Tensor], ratio: int) -> None:
    boxes = torch.tensor(BOXES * 2, dtype=torch.float64)
    image = torch.tensor([0, 1] * len(BOXES))
    level = torch.tensor([0] * len(BOXES) + [1] * len(BOXES))
    pooled = roi_align(levels, boxes, image, level, 3, SCALES, ratio)
    for k, box in enumerate(boxes.tolist()):
        features = levels[level[k]][image[k]]
        expected = _by_loops(features, box, 3, SCALES[level[k]], ratio)
        torch.testing.assert_close(pooled[k], expected, atol=1e-12, rtol=0)


def test_the_variant_of_branch_master(levels: list[Tensor]) -> None:
    boxes = torch.tensor([box for box in BOXES if box[2] != 59], dtype=torch.float64)
    zeros = torch.zeros(len(boxes), dtype=torch.long)
    pooled = roi_align(levels, boxes, zeros, zeros, 4, SCALES, places="corners")
    for k, box in enumerate(boxes.tolist()):
        expected = _master_by_loops(levels[0][0], box, 4, SCALES[0])
        torch.testing.assert_close(pooled[k], expected, atol=1e-12, rtol=0)


def test_a_ramp_has_its_value_at_the_middle_of_a_bin() -> None:
    ramp = torch.arange(40.0).expand(1, 1, 20, 40)
    zero = torch.zeros(1, dtype=torch.long)
    box = torch.tensor([[8.0, 4.0, 64.0, 30.0]])
    pooled = roi_align([ramp], box, zero, zero, 7, [0.5])
    columns = 4 + (torch.arange(7) + 0.5) * 4  # the box spans cells 4 to 32
    torch.testing.assert_close(pooled[0, 0], columns.expand(7, 7))


@pytest.mark.parametrize("places", ["centres", "corners"])
def test_gradient_to_the_features_agrees_with_finite_differences(
    levels: list[Tensor], places: SamplePlaces
) -> None:
    boxes = torch.tensor(BOXES[:4], dtype=torch.float64)
    image, level = torch.tensor([0, 1, 1, 0]), torch.tensor([0, 1, 0, 1])

    def pooled(first: Tensor, second: Tensor) -> Tensor:
        return roi_align([first, second], boxes, image, level, 3, SCALES, places=places)

    inputs = [features[:, :1].clone().requires_grad_() for features in levels]
    assert torch.autograd.gradcheck(pooled, inputs, fast_mode=True)


def test_no_box_gives_no_output(levels: list[Tensor]) -> None:
    none = torch.zeros(0, dtype=torch.long)
    pooled = roi_align(levels, torch.zeros(0, 4, dtype=torch.float64), none, none, 7, SCALES)
    assert pooled.shape == (0, 3, 7, 7)
