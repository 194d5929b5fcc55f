"""The validator `connected`: a car's LiDAR judged by what the vehicles around it scan."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.connected_scans import ConnectedScans, ScanPose, SharedScan
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.pipeline import Pipeline
from avsec_gym.registry import Kind, make
from avsec_gym.rig import kitti_rig
from avsec_gym.scenario.scene import Scene
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.compromised_sensors import Untrusted
from avsec_gym.validation.connected.frame_validator import FrameValidator, vehicle_scans
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from avsec_gym.validation.response import Response, trusted_frame
from avsec_gym.validation.state_posterior import SensorStatus

_CAR, _GHOST = (14.0, 3.0, 0.1), (15.0, -4.0, -0.2)
_Street = Callable[..., list[VehicleScan]]


@pytest.fixture(scope="module")
def validator() -> FrameValidator:
    found: FrameValidator = make(Kind.VALIDATOR, {"name": "connected", "alarms": 0.05})
    return found


def frame_of(scans: list[VehicleScan], *, lazily: bool = False) -> SensorFrame:
    """The frame of the first vehicle, what the others share beside it."""

    def place(scan: VehicleScan) -> ScanPose:
        return ScanPose(scan.pose, scan.time, 0.0, 0.0, scan.sweep.period, scan.roadside)

    def shared() -> ConnectedScans:
        others = [
            SharedScan((lambda points=scan.points: points) if lazily else scan.points, place(scan))
            for scan in scans[1:]
        ]
        return ConnectedScans(place(scans[0]), tuple(others))

    neighbours = shared if lazily else shared()
    calibration = kitti_rig().calibration
    return SensorFrame("000001", calibration, scan=scans[0].points, neighbours=neighbours)


def points_at(frame: SensorFrame, box: tuple[float, float, float]) -> int:
    """Points well above the ground within 3 m of a car's middle; the first vehicle is at 0."""
    near = np.hypot(*(frame.points[:, :2] - box[:2]).T) < 3.0
    return int((near & (frame.points[:, 2] > -1.3)).sum())


def test_a_ghost_in_the_cars_own_scan_is_named_and_taken_out(
    street: _Street, validator: FrameValidator
) -> None:
    frame = frame_of(street((_CAR, _GHOST), (_CAR,), (_CAR,)))
    found = validator.validate(frame)
    assert found.alarm
    assert found.statuses == {LIDAR: SensorStatus.ATTACKED}
    assert found.attacked == {LIDAR}
    assert points_at(frame, _GHOST) > 100
    repaired = trusted_frame(frame, found, Response.REPAIR)
    assert points_at(repaired, _GHOST) == 0
    assert points_at(repaired, _CAR) == points_at(frame, _CAR) > 100
    with pytest.raises(Untrusted, match="LiDAR"):
        _ = trusted_frame(frame, found, Response.DROP).points
    with pytest.raises(Untrusted):
        trusted_frame(frame, found, Response.STOP)


def test_a_removed_car_comes_back(street: _Street, validator: FrameValidator) -> None:
    frame = frame_of(street((), (_CAR,), (_CAR,)), lazily=True)
    found = validator.validate(frame)
    assert found.statuses == {LIDAR: SensorStatus.ATTACKED}
    assert points_at(frame, _CAR) == 0
    assert points_at(found.repaired(frame), _CAR) > 20


def test_what_others_suffer_is_no_alarm_of_this_car(
    street: _Street, validator: FrameValidator
) -> None:
    frame = frame_of(street((_CAR,), (_CAR, _GHOST), (_CAR,)))
    found = validator.validate(frame)
    assert found.result.accused == (1,)
    assert not found.alarm
    assert found.statuses == {LIDAR: SensorStatus.SOUND}
    assert trusted_frame(frame, found, Response.REPAIR) is frame


def test_with_one_other_vehicle_the_status_stays_open_and_the_scan_is_refused(
    street: _Street, validator: FrameValidator
) -> None:
    frame = frame_of(street((_CAR, _GHOST), (_CAR,), (_CAR,))[:2])
    found = validator.validate(frame)
    assert found.alarm
    assert found.statuses == {LIDAR: SensorStatus.CANNOT_TELL}
    with pytest.raises(Untrusted):
        _ = found.repaired(frame).points


def test_clean_frames_pass_and_lonely_ones_are_refused(
    street: _Street, validator: FrameValidator
) -> None:
    frame = frame_of(street((_CAR,), (_CAR,), (_CAR,)))
    assert not validator.validate(frame).alarm
    with pytest.raises(DataError, match="No other vehicle shares"):
        validator.validate(replace(frame, neighbours=None))
    with pytest.raises(DataError, match="no LiDAR scan"):
        validator.validate(replace(frame, scan=None))
    with pytest.raises(ConfigurationError, match="alarms"):
        make(Kind.VALIDATOR, {"name": "connected", "alarms": 2.0})


def test_scans_keep_where_and_how_they_were_taken(street: _Street) -> None:
    scans = street((_CAR,), (_CAR,), (_CAR,))
    scans[2] = replace(scans[2], roadside=True, time=0.03)
    for mine, theirs in zip(scans, vehicle_scans(frame_of(scans, lazily=True)), strict=True):
        np.testing.assert_array_equal(mine.points, theirs.points)
        np.testing.assert_array_equal(mine.pose, theirs.pose)
        assert (mine.time, mine.sweep, mine.roadside) == (
            theirs.time,
            theirs.sweep,
            theirs.roadside,
        )


def test_a_pipeline_drives_on_with_what_the_others_give_back(street: _Street) -> None:
    frame = frame_of(street((_CAR, _GHOST), (_CAR,), (_CAR,)))
    scene = Scene("000001", Boxes3D.empty())

    def believed_at(box: tuple[float, float, float], **parts: object) -> bool:
        boxes = Pipeline("scan_obstacles", **parts)(scene, frame).perception.believed  # type: ignore[arg-type]
        ahead, left = boxes.location[:, 2], -boxes.location[:, 0]
        return bool((np.hypot(ahead - box[0], left - box[1]) < 2.0).any())

    assert believed_at(_GHOST)
    assert not believed_at(_GHOST, validator="connected", response="repair")
    assert believed_at(_CAR, validator="connected", response="repair")
    stopped = Pipeline("scan_obstacles", validator="connected")(scene, frame)
    assert stopped.perception.stops
