"""How located and repaired damage is judged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.localisation import (
    Located,
    Overlap,
    attacks_of,
    found_again,
    overlap,
    summary,
)


def test_overlap_of_two_areas() -> None:
    found, true = np.zeros((2, 10, 10), bool)
    found[:, :6] = True
    true[:, 4:] = True
    assert overlap(found, true) == Overlap(20 / 100, 20 / 60, 20 / 60)
    assert overlap(found, ~true | true) == Overlap(0.6, 1.0, 0.6)
    assert overlap(true & ~true, true & ~true) == Overlap(None, None, None)


def test_objects_are_found_again_by_place_and_category() -> None:
    count = 3
    objects = Boxes3D(
        np.zeros((count, 3)),
        np.ones((count, 3)),
        np.zeros(count),
        np.ones(count),
        np.array(["Car", "Car", "Cyclist"]),
        box2d=np.array([[0, 0, 100, 100], [200, 0, 300, 100], [400, 0, 500, 100.0]]),
    )
    assert found_again(objects, objects) == count
    right = np.array([1.0, 0.0, 1.0, 0.0])
    assert objects.box2d is not None
    moved = replace(objects, box2d=objects.box2d + 40 * right)
    assert found_again(objects, moved) == 0
    moved = replace(objects, box2d=objects.box2d + 30 * right)
    assert found_again(objects, moved) == count
    others = replace(objects, category=np.array(["Car", "Pedestrian", "Car"]))
    assert found_again(objects, others) == 1
    assert found_again(objects, Boxes3D.empty()) == 0


def test_attacks_are_summed_up_by_name() -> None:
    rows = [
        Located("0", "spot", Overlap(0.5, 1.0, 0.5), objects=3, found_before=1, found_after=2),
        Located("1", "spot", Overlap(0.9, 1.0, 0.9), objects=2, found_before=0, found_after=2),
        Located("2", "spot", Overlap(None, None, None)),
    ]
    told = summary(rows)["spot"]
    assert told["frames"] == 3
    assert told["iou"] == pytest.approx(0.7)
    assert told["lowest_iou"] == 0.5
    assert told["error_after"] is None
    assert (told["objects"], told["found_before"], told["found_after"]) == (5, 1, 4)


def test_every_attack_has_a_name_of_its_own_sensor() -> None:
    assert {next(iter(attack.sensors)) for attack in attacks_of(3).values()} == {3, "lidar"}
