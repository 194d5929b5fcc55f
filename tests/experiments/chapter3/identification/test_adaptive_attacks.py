"""Attackers who know the method keep to what it does not look at."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.experiments.chapter3.identification.adaptive_attacks import (
    AGREED_DEPTH,
    AGREEING,
    DIM,
    FAR,
    KINDS,
    OUT_OF_SIGHT,
    REMOVED,
    VEIL,
    Tampered,
    states_of,
)
from avsec_gym.experiments.chapter3.recordings import SYSTEM
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import project, transform_points
from avsec_gym.rig import camera_rig
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.evidence.brightness import MIN_LIGHT


@pytest.fixture(scope="module")
def frame() -> SensorFrame:
    """Black images, in which light is all that there is."""
    rig = camera_rig((0.0, 0.54, -0.27, 0.27))
    images = {c: np.zeros((375, 1242, 3), np.uint8) for c in SYSTEM.cameras}
    rng = np.random.default_rng(0)
    points = rng.uniform((5.0, -5.0, -1.7, 0.0), (40.0, 5.0, 0.0, 1.0), (5000, 4))
    return SensorFrame("0000000000", rig.calibration, images, points.astype(np.float32))


def tampered(frame: SensorFrame, kind: str, seed: int = 1) -> Tampered:
    return KINDS[kind].tamper(frame, SYSTEM, (seed, 2))


def test_every_kind_attacks_who_it_says_and_draws_the_same_again(frame: SensorFrame) -> None:
    for name, kind in KINDS.items():
        first, again = tampered(frame, name), tampered(frame, name)
        wanted = {SYSTEM.sensors[index] for attacked in kind.attacked for index in attacked}
        assert wanted <= set(first)
        for sensor, hit in first.items():
            assert hit.attacked == {sensor}
            other = again[sensor].frame
            np.testing.assert_array_equal(hit.frame.points, other.points)
            for camera in SYSTEM.cameras:
                np.testing.assert_array_equal(hit.frame.image(camera), other.image(camera))
        states = states_of(kind, len(SYSTEM))
        assert [tuple(np.flatnonzero(state)) for state in states] == list(kind.attacked)


def test_dim_light_is_below_what_counts_and_a_veil_is_the_same_everywhere(
    frame: SensorFrame,
) -> None:
    centres = set()
    for camera in SYSTEM.cameras:
        dim = tampered(frame, DIM)[camera]
        assert 0 < dim.frame.image(camera).max() < MIN_LIGHT
        centres.add(dim.settings["u"])
        veil = tampered(frame, VEIL)[camera].frame.image(camera)
        assert veil.min() == veil.max() > MIN_LIGHT
    assert len(centres) == 3


def test_light_that_agrees_is_where_a_surface_would_be(frame: SensorFrame) -> None:
    found = tampered(frame, AGREEING)
    at = {camera: found[camera].settings for camera in SYSTEM.cameras}
    place = np.array([[0.0, 0.0, AGREED_DEPTH]])
    seen = {c: project(frame.calibration.projection(c), place)[0][0] for c in SYSTEM.cameras}
    for camera in SYSTEM.cameras:
        assert at[camera]["radius"] == at[2]["radius"]
        assert at[camera]["v"] == at[2]["v"]
        assert at[camera]["u"] - at[2]["u"] == pytest.approx(seen[camera][0] - seen[2][0])


def test_returns_are_far_or_gone_or_beside_the_images(frame: SensorFrame) -> None:
    assert 20 <= tampered(frame, FAR)[LIDAR].settings["distance"] <= 30
    left = tampered(frame, REMOVED)[LIDAR].frame.points
    everything = {tuple(point) for point in frame.points}
    assert {tuple(point) for point in left} < everything
    assert 0 < len(left) < len(frame.points)
    beside = tampered(frame, OUT_OF_SIGHT)[LIDAR]
    assert beside.points is not None
    bogus = beside.frame.points[beside.points][:, :3].astype(float)
    in_camera = transform_points(frame.calibration.velodyne_to_camera, bogus)
    assert len(bogus)
    for camera in SYSTEM.cameras:
        pixels, depth = project(frame.calibration.projection(camera), in_camera)
        assert not ((depth > 0) & (pixels[:, 0] > 0) & (pixels[:, 0] < 1242)).any()
