from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.closed_loop.recorded.ego_motion import estimate_motion
from avsec_gym.closed_loop.recorded.recorded_motion import from_first
from avsec_gym.closed_loop.recorded.tracking_traffic import traffic_of_frames
from avsec_gym.closed_loop.recorded.windows import known_motion
from avsec_gym.world.drives import drive_scenes
from studies.driving_safety.procedural_labels import drive_labels

from .made_traffic import driving, motion, parked, traffic


@pytest.mark.parametrize(("speed", "turning"), [(5.0, 0.0), (12.0, 0.0), (8.0, 0.05)])
def test_exact_labels_of_parked_cars_give_the_motion(speed: float, turning: float) -> None:
    ego = motion(speed, turning)
    estimate = estimate_motion(traffic(ego, parked()))
    assert np.abs(estimate.poses[:, :2] - ego[:, :2]).max() < 0.1
    assert np.abs(estimate.poses[:, 2] - ego[:, 2]).max() < 0.01
    assert estimate.residual < 0.02


def test_cars_that_drive_are_not_taken_as_standing() -> None:
    ego = motion(9.0)
    movers = [driving(20.0, 0.0, 9.5), driving(120.0, 3.0, -8.0)]
    estimate = estimate_motion(traffic(ego, [*parked(), *movers]))
    first = len(parked())
    assert {first, first + 1}.isdisjoint(each.id for each in estimate.standing)
    assert np.abs(estimate.poses[-1] - ego[-1]).max() < 0.1


def test_a_car_that_leads_does_not_make_the_car_stand() -> None:
    ego = motion(9.0)
    estimate = estimate_motion(traffic(ego, [*parked(), driving(15.0, 0.0, 9.0)]))
    assert abs(estimate.poses[-1, 0] - ego[-1, 0]) < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("number", [3, 9, 18, 24])
def test_the_drift_on_procedural_drives_is_small(number: int) -> None:
    """The study `ego_motion` has the drift of all of its drives."""
    scenes = drive_scenes(7, number, 101)
    frames, truth = drive_labels(scenes, number)
    known = known_motion(traffic_of_frames("drive", len(frames), frames, None))
    starts, _ = known.starts(1.0)
    assert starts
    for first in starts:
        estimated = from_first(known.poses, first)[first + 80]
        true = from_first(truth, first)[first + 80]
        assert np.hypot(*(estimated - true)[:2]) < 0.7
        assert abs(estimated[2] - true[2]) < np.radians(1.0)
