"""Precision of cars against `average_precision`, and its intervals by drive."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.objects.car_precision import car_precision
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES
from avsec_gym.metrics.average_precision import LEVELS, average_precision

PLACES = np.array([[-3.0, 1.65, 15.0], [2.0, 1.65, 20.0]])


def cars(*which: int) -> Boxes3D:
    chosen = list(which)
    box2d = np.array([[400.0, 150, 520, 250], [650, 160, 720, 220]])[chosen]
    count, nothing = len(chosen), np.zeros(len(chosen))
    return Boxes3D(
        PLACES[chosen], np.tile([1.5, 1.6, 4.0], (count, 1)), np.full(count, -1.57),
        np.linspace(0.9, 0.8, count), np.full(count, "Car"), box2d=box2d,
        truncation=nothing, occlusion=nothing, alpha=nothing,
    )  # fmt: skip


def scenes(drives: int, frames: int) -> tuple[dict[str, Boxes3D], dict[str, Boxes3D], list[str]]:
    """Every third drive hides the second car, in all of its frames."""
    ids = [f"{drive:03d}/{frame}" for drive in range(drives) for frame in range(frames)]
    found = {id: cars(0) if int(id[:3]) % 3 == 0 else cars(0, 1) for id in ids}
    return dict.fromkeys(ids, cars(0, 1)), found, ids


def test_it_is_kittis_precision() -> None:
    truth, found, frames = scenes(30, 1)
    for metric, place in (("2d", 0), ("3d", 2)):
        own = car_precision(truth, found, frames, metric, 0.7)
        known = average_precision(
            [*truth.values()], [*found.values()], classes=["Car"], resamples=RESAMPLES
        )
        assert known.drawn is not None
        for level, name in enumerate(LEVELS):
            assert own[name].value == pytest.approx(known.ap11[0, place, level])
            # Where each frame is a drive of its own, drives are drawn as frames are.
            np.testing.assert_allclose(own[name].samples, known.drawn[0, place, level, :, 0])


def test_frames_that_are_alike_tell_no_more_than_one() -> None:
    once, often = (car_precision(*scenes(30, frames), "3d", 0.7) for frames in (1, 5))
    assert often["moderate"].interval == pytest.approx(once["moderate"].interval)


def test_one_drive_has_no_interval() -> None:
    assert car_precision(*scenes(1, 5), "3d", 0.7)["moderate"].interval is None
