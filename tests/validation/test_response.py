"""After an alarm: what detectors get of the compromised sensors, and that nothing moves by it."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import project
from avsec_gym.perception.depth.sgbm import SemiGlobalMatching
from avsec_gym.rig import SensorRig, camera_rig
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem
from avsec_gym.validation.compromised_sensors import (
    Untrusted,
    with_compromised_sensors_repaired,
    without_compromised_sensors,
)
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.response import Response, trusted_frame
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Validation

SYSTEM = SensorSystem((LIDAR, 1, 3, 2))
FOCAL_LENGTH, DEPTH = 200.0, 8.0
PLACES = (0.0, 0.56, -0.28, 0.28)


def rig_of(places: tuple[float, ...] = PLACES) -> SensorRig:
    return camera_rig(places, focal_length=FOCAL_LENGTH, centre=(120.0, 60.0), size=(240, 120))


def wall(places: tuple[float, ...] = PLACES) -> SensorFrame:
    """A wall of dark random dots 8 m ahead; cameras see it 25 pixels to the left for each metre."""
    calibration = rig_of(places).calibration
    rng = np.random.default_rng(0)
    dots = rng.integers(0, 100, (120, 300, 1), np.uint8).repeat(3, axis=2)
    starts = [20 + round(FOCAL_LENGTH * place / DEPTH) for place in places]
    images = {camera: dots[:, start : start + 240] for camera, start in enumerate(starts)}
    x, y = np.meshgrid(np.linspace(-5, 5, 150), np.linspace(-2, 2, 40))
    spots = np.stack([x.ravel(), y.ravel(), np.full(x.size, DEPTH), np.ones(x.size)], axis=1)
    points = (spots @ calibration.camera_to_velodyne.T).astype(np.float32)
    before = SensorFrame("000000", calibration, {camera: images[camera] for camera in (1, 2, 3)})
    return SensorFrame("000001", calibration, images, points, previous=(before,))


def said(
    frame: SensorFrame, *compromised: Sensor, status: SensorStatus = SensorStatus.ATTACKED
) -> Validation:
    sound = SensorStatus.SOUND
    statuses = {sensor: status if sensor in compromised else sound for sensor in SYSTEM.sensors}
    return Validation(bool(compromised), statuses, DisparityErrors(DisparityMaps(frame, SYSTEM)))


@pytest.mark.parametrize(("compromised", "pair"), [(3, (2, 1)), (2, (3, 1))])
def test_another_pair_stands_in_and_depth_stays(compromised: int, pair: tuple[int, int]) -> None:
    frame = wall()
    left = without_compromised_sensors(frame, said(frame, compromised))
    assert sorted(left.images) == [2, 3]
    for number, camera in zip((2, 3), pair, strict=True):
        assert left.image(number) is frame.image(camera)
        assert left.previous[0].image(number) is frame.previous[0].image(camera)
        place = np.array([1.0, 0.5, 10.0])
        there = project(left.calibration.projection(number), place)[0]
        assert there == pytest.approx(project(frame.calibration.projection(camera), place)[0])
    found = SemiGlobalMatching(disparities=32).disparity(left).depth
    assert np.nanmedian(found) == pytest.approx(DEPTH, rel=0.02)
    assert left.points is frame.points


def test_who_looks_elsewhere_goes_on_and_the_compromised_sensor_is_not_looked_at() -> None:
    frame = wall()
    left = without_compromised_sensors(frame, said(frame, LIDAR, 1))
    assert left.image(2) is frame.image(2)
    assert left.image(3) is frame.image(3)
    for ask in (partial(left.image, 1), lambda: left.points):
        with pytest.raises(Untrusted, match="nothing takes its place"):
            ask()


def test_a_pair_too_close_is_none() -> None:
    frame = wall((0.0, 0.56, -0.28, 0.40))  # Between 3 and 1 less than a fourth of the usual.
    with pytest.raises(Untrusted):
        without_compromised_sensors(frame, said(frame, 2)).image(2)
    assert without_compromised_sensors(frame, said(frame, 3)).image(3) is frame.image(1)


def test_where_nothing_can_be_told_nothing_is_used() -> None:
    frame = wall()
    validation = said(frame, *SYSTEM.sensors, status=SensorStatus.CANNOT_TELL)
    for left in (
        without_compromised_sensors(frame, validation),
        with_compromised_sensors_repaired(frame, validation),
    ):
        with pytest.raises(Untrusted, match="camera 2"):
            left.image(2)
        with pytest.raises(Untrusted, match="LiDAR"):
            _ = left.points


def test_a_camera_is_repaired_when_it_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    clean = wall()
    spoiled = clean.image(3).copy()
    spoiled[:, 80:160] = 255
    frame = clean.with_image(3, spoiled)
    left = with_compromised_sensors_repaired(frame, said(frame, 3))
    with monkeypatch.context() as without:
        without.setattr("avsec_gym.validation.repair.repair", None)
        assert left.image(2) is frame.image(2)
        assert left.points is frame.points
    repaired = left.image(3)
    before, after = (
        np.abs(np.subtract(image, clean.image(3), dtype=float))[:, 80:160].mean()
        for image in (spoiled, repaired)
    )
    assert after < 0.3 * before


def test_bogus_points_are_taken_out_of_a_repaired_scan() -> None:
    clean = wall()
    bogus = clean.points[np.abs(clean.points[:, 1]) < 1.5] * np.float32(0.6)
    frame = clean.with_points(np.concatenate([clean.points, bogus]))
    repaired = with_compromised_sensors_repaired(frame, said(frame, LIDAR)).points
    near = [(points[:, 0] < 0.8 * DEPTH).sum() for points in (frame.points, repaired)]
    assert near[1] < 0.1 * near[0]


def test_responses_to_an_alarm_and_to_none() -> None:
    frame = wall()
    for response in Response:
        assert trusted_frame(frame, said(frame), response) is frame
    with pytest.raises(Untrusted, match="alarm"):
        trusted_frame(frame, said(frame, 1), Response.STOP)
    assert trusted_frame(frame, said(frame, 3), Response.DROP).image(3) is frame.image(1)
    assert trusted_frame(frame, said(frame, 1), Response.REPAIR).image(3) is frame.image(3)
    assert Response.named("drop") is Response.DROP
    with pytest.raises(ConfigurationError, match=r"Known: stop"):
        Response.named("pray")


def test_a_frame_without_scan_stays_without() -> None:
    frame = replace(wall(), scan=None)
    assert not without_compromised_sensors(frame, said(frame, LIDAR)).has_points
