"""Targets by another library's polygons, and back to the rectangles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
import torch

from avsec_gym.geometry import Floats, bird_eye_iou, rectangle_polygons
from avsec_gym.perception.detectors.pixor.cell_coding import decode
from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration
from avsec_gym.perception.detectors.pixor.decoding import PixorDecodingRule, found_rectangles
from avsec_gym.perception.detectors.pixor.network import PixorOutput
from avsec_gym.perception.detectors.pixor.targets import PixorTargets, cell_targets

CARS = np.array(
    [[6.0, 1.0, 4.0, 1.7, 0.3], [12.3, -2.2, 3.6, 1.5, -2.9], [17.0, 5.0, 4.4, 1.8, 1.5]]
)
OTHER = np.array([[14.0, 3.0, 6.0, 2.2, 0.7]])


def middles_within(rectangles: Floats, configuration: PixorConfiguration) -> Floats:
    """For each rectangle, which middles of cells shapely finds within it: (N, rows, columns)."""
    poses, length, width = rectangles[:, [0, 1, 4]], rectangles[:, 2], rectangles[:, 3]
    middles = configuration.corners() + configuration.output_cell / 2
    points = shapely.points(middles)
    polygons = rectangle_polygons(poses, length, width)
    return np.array([shapely.contains(polygon, points) for polygon in polygons])


def test_cells_on_cars_are_positive_and_tell_their_car(tiny: PixorConfiguration) -> None:
    targets = cell_targets(CARS, tiny)
    within = middles_within(CARS, tiny)
    np.testing.assert_array_equal(targets.positive[0], within.any(axis=0))
    assert targets.judged.all()
    for car, cells in zip(CARS, within, strict=True):
        assert 25 < cells.sum() < 60
        values = targets.values[0, :, torch.from_numpy(cells)].T.double().numpy()
        told = decode(values, tiny.corners()[cells], tiny)
        np.testing.assert_allclose(told, np.tile(car, (len(told), 1)), atol=1e-5)


def test_offsets_scatter_about_the_mean_of_the_original(tiny: PixorConfiguration) -> None:
    """Cells tell the way from their corner: half a cell (0.2 m) more than from their middle."""
    targets = cell_targets(CARS, replace(tiny, mean=(0.0,) * 6, deviation=(1.0,) * 6))
    dx, dy = targets.values[0, 2:4, targets.positive[0]].mean(dim=1).tolist()
    assert abs(dx - 0.2) < 0.05
    assert abs(dy - 0.2) < 0.05


def test_unsure_objects_and_directions_are_not_judged(tiny: PixorConfiguration) -> None:
    targets = cell_targets(CARS, tiny, ignored=OTHER, azimuths=(-0.6, 0.5))
    ignored = middles_within(OTHER, tiny)[0] & ~middles_within(CARS, tiny).any(axis=0)
    x, y = np.moveaxis(tiny.corners() + tiny.output_cell / 2, -1, 0)
    seen = (y < x * np.tan(0.5)) & (y > -x * np.tan(0.6))
    np.testing.assert_array_equal(targets.judged[0], seen & ~ignored)
    assert ignored.any()


def test_an_output_that_is_the_target_becomes_the_rectangles(tiny: PixorConfiguration) -> None:
    targets = PixorTargets.concatenate([cell_targets(CARS, tiny), cell_targets(CARS[:1], tiny)])
    logits = torch.where(targets.positive, 3.0, -9.0)
    in_view = torch.ones(tiny.output_shape, dtype=torch.bool)
    # Neighbours of a car that tell nearly the same, less surely: they are suppressed.
    logits[0, 10, 30], targets.values[0, :, 10, 30] = 0.0, targets.values[0, :, 18, 30]
    output = PixorOutput(logits, targets.values, in_view)
    both = found_rectangles(output, tiny, PixorDecodingRule(candidates=512))
    for (found, scores), cars in zip(both, (CARS, CARS[:1]), strict=True):
        assert len(found) >= len(cars)
        overlap = bird_eye_iou(cars[:, [0, 1, 4]], cars[:, 2:4], found[:, [0, 1, 4]], found[:, 2:4])
        assert (overlap.max(axis=1) > 0.999).all()
        assert (np.diff(scores) <= 0).all()
    few = found_rectangles(output, tiny, PixorDecodingRule(candidates=1))
    assert [len(scores) for _, scores in few] == [1, 1]


def test_nothing_becomes_nothing(tiny: PixorConfiguration) -> None:
    targets = cell_targets(np.zeros((0, 5)), tiny)
    assert not targets.positive.any()
    output = PixorOutput(
        torch.full((1, *tiny.output_shape), -9.0), targets.values, torch.ones(tiny.output_shape) > 0
    )
    [(rectangles, scores)] = found_rectangles(output, tiny)
    assert rectangles.shape == (0, 5)
    assert scores.shape == (0,)
