"""What is found by other pairs of cameras, on walls of dots with a detector that is known."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.json_rows import row_json
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import SensorSystem
from avsec_gym.validation.recordings import raw_recordings
from studies.chapter3 import other_pairs
from studies.chapter3.other_pairs import (
    cars_ahead,
    distances,
    found_by_pairs,
)


def boxes(*places: tuple[float, float], category: str = "Car") -> Boxes3D:
    count = len(places)
    location = np.array([(x, 1.65, z) for x, z in places]).reshape(-1, 3)
    size = np.tile([1.5, 1.6, 4.0], (count, 1))
    return Boxes3D(location, size, np.zeros(count), np.ones(count), np.full(count, category))


def test_a_car_is_found_in_its_direction_at_whatever_distance() -> None:
    cars = boxes((0.0, 10.0), (5.0, 20.0), (-4.0, 12.0))
    found = boxes((0.1, 9.0), (10.0, 40.0))
    assert distances(cars, found) == pytest.approx([0.9, 2.0, np.nan], nan_ok=True)
    twins = boxes((0.0, 10.0), (0.0, 20.0))
    assert np.isnan(distances(twins, found[:1])).sum() == 1, "one box finds one car"
    assert np.isnan(distances(cars, boxes())).all()
    assert len(distances(boxes(), cars)) == 0
    both = Boxes3D.concatenate(
        [cars, boxes((0.0, 4.0), (0.0, 41.0)), boxes((1, 9), category="Van")]
    )
    np.testing.assert_array_equal(cars_ahead(both).location, cars.location)


class OfOneBaseline:
    """Sees the car at 12 m by the pair that it knows, and by others half the time, at 6 m."""

    name = "of_one_baseline"

    def __init__(self, usual: float) -> None:
        self._usual, self._asked = usual, 0

    def detect(self, frame: SensorFrame) -> Boxes3D:
        assert sorted(frame.images) == [LEFT, RIGHT]
        if frame.calibration.baseline(LEFT, RIGHT) == pytest.approx(self._usual):
            return boxes((0.0, 12.0))
        self._asked += 1
        return boxes((0.0, 6.0)) if self._asked % 2 else boxes((9.0, 12.0))


def test_pairs_are_told_apart(tmp_path: Path, walls: ModuleType) -> None:
    recordings = raw_recordings(
        walls.write_labelled_drives(tmp_path, 1, 4), SensorSystem(("lidar", 1, 3, 2)).sensors
    )
    usual = recordings.frames[0].frame().calibration.baseline(LEFT, RIGHT)
    rows = found_by_pairs(recordings, OfOneBaseline(usual), 0.5)
    first, *others = rows
    assert (first.left, first.right, first.baseline) == (LEFT, RIGHT, 1.0)
    assert first.found.count == first.found.of == 4
    assert row_json(first.distance) == pytest.approx({"median": 1.0, "from": 1.0, "to": 1.0})
    assert others
    assert sum(row.found.count for row in others) == 2 * len(others)
    for row in others:
        # Four frames of one drive: as little as one.
        assert row.found.interval[1] - row.found.interval[0] > 0.5
        assert row.baseline >= 0.4
        if row.found.count:
            assert row.distance.median == pytest.approx(0.5)


def test_an_unknown_detector_is_said(caplog: pytest.LogCaptureFixture) -> None:
    assert other_pairs.main(["--detector", "unheard_of"]) == 1
    assert "unheard_of" in caplog.text
