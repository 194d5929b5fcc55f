"""Going on after an alarm: a frame without its compromised sensors, or with their data repaired.

Compromised are the sensors whose status is attacked, and those whose status is open.  Data that
nothing can replace raise `Untrusted` when they are asked for, and not before: a camera detector
goes on without the LiDAR.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from itertools import permutations
from typing import Any, NoReturn

import numpy as np

from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration, LazyImages, SensorFrame
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem, sensor_name
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Judgement, Validation

SHORTEST_BASELINE = 0.4
"""Share of the usual baseline; a detector that expects that one takes what a shorter one sees for
far away."""


class Untrusted(DataError):
    """What is asked for is not to be trusted, and nothing takes its place."""


def without_compromised_sensors(frame: SensorFrame, validation: Judgement) -> SensorFrame:
    """The frame without the data of compromised sensors.

    If a camera of the stereo pair is compromised, another pair of sound cameras replaces both:
    under their numbers, with its own projections, so that objects are where they were.  It is the
    pair whose baseline is most like theirs, and at least 0.4 of it.

    Args:
        frame: The frame that the validator judged.
        validation: The result of that validator.
    """
    sound, compromised = _parted(validation)
    if {LEFT, RIGHT} & set(compromised) and (pair := _stand_in(frame, sound)) is not None:
        frame = as_stereo_pair(frame, *pair)
        compromised = [LIDAR] if LIDAR in compromised else []
    return _with(frame, {sensor: partial(_refuse, frame, sensor) for sensor in compromised})


def with_compromised_sensors_repaired(frame: SensorFrame, validation: Validation) -> SensorFrame:
    """The frame with the data of compromised sensors repaired, each when it is asked for.

    Two sound sensors, one of them a camera, repair a camera; two sound cameras repair the LiDAR.
    See `avsec_gym.validation.repair.repair`.

    Args:
        frame: The frame that the validator judged.
        validation: The result of that validator.
    """
    sound, compromised = _parted(validation)
    return _with(
        frame,
        {sensor: partial(_repaired, frame, validation, sound, sensor) for sensor in compromised},
    )


def _parted(validation: Judgement) -> tuple[list[Sensor], list[Sensor]]:
    """Sound and compromised sensors, the LiDAR first, then cameras from right to left."""
    sensors = list(validation.statuses)
    sound = [sensor for sensor in sensors if validation.statuses[sensor] == SensorStatus.SOUND]
    return sound, [sensor for sensor in sensors if sensor not in sound]


def _with(frame: SensorFrame, sources: Mapping[Sensor, Callable[[], Any]]) -> SensorFrame:
    """The frame with other images and scans, loaded when they are asked for."""
    images = {c: sources.get(c, partial(frame.image, c)) for c in frame.images}
    scan = sources.get(LIDAR, frame.scan) if frame.has_points else None
    return replace(frame, images=LazyImages(images), scan=scan)


def _stand_in(frame: SensorFrame, sound: list[Sensor]) -> tuple[int, int] | None:
    """The sound pair, left and right, that is most like the stereo pair."""
    if not {LEFT, RIGHT} <= set(frame.calibration.cameras):
        return None
    cameras = [sensor for sensor in sound if isinstance(sensor, int) and sensor in frame.images]
    return next(iter(stereo_pairs(frame.calibration, cameras)), None)


def stereo_pairs(calibration: Calibration, cameras: Iterable[int]) -> dict[tuple[int, int], float]:
    """Pairs that may replace cameras 2 and 3, the most like them first.

    Args:
        calibration: The calibration of the rig.
        cameras: The cameras that may be of a pair.

    Returns:
        By left and right camera the baseline, over that of cameras 2 and 3.
    """
    usual = calibration.baseline(LEFT, RIGHT)
    shares = {pair: calibration.baseline(*pair) / usual for pair in permutations(cameras, 2)}
    likeness = {
        pair: abs(np.log(share)) for pair, share in shares.items() if share >= SHORTEST_BASELINE
    }
    return {pair: shares[pair] for pair in sorted(likeness, key=likeness.__getitem__)}


def as_stereo_pair(frame: SensorFrame, left: int, right: int) -> SensorFrame:
    """Two cameras as `LEFT` and `RIGHT`, and no others; also in the frames before.

    Args:
        frame: The frame.
        left: The number of the left camera.
        right: The number of the right camera.
    """
    numbers = {LEFT: left, RIGHT: right}
    projections = np.zeros_like(frame.calibration.projections)
    for number, camera in numbers.items():
        projections[number] = frame.calibration.projection(camera)
    there = {number: camera for number, camera in numbers.items() if camera in frame.images}
    return replace(
        frame,
        calibration=replace(frame.calibration, projections=projections),
        images=LazyImages({n: partial(frame.image, camera) for n, camera in there.items()}),
        previous=tuple(as_stereo_pair(before, left, right) for before in frame.previous),
    )


def _repaired(
    frame: SensorFrame, validation: Validation, sound: list[Sensor], compromised: Sensor
) -> Any:
    """The repaired image or scan of a compromised sensor."""
    # Few frames are repaired, and the repair takes long to import.
    from avsec_gym.validation.repair.repair import repair

    maps = validation.errors.maps
    judges = tuple(
        sensor for sensor in maps.system.sensors if sensor in sound or sensor == compromised
    )
    try:
        repaired = repair(frame, SensorSystem(judges), {compromised}, maps.depth).frame
    except ConfigurationError:
        _refuse(frame, compromised)
    return repaired.points if compromised == LIDAR else repaired.image(int(compromised))


def _refuse(frame: SensorFrame, compromised: Sensor) -> NoReturn:
    name = sensor_name(compromised)
    raise Untrusted(
        f"Frame {frame.id}: {name} is not to be trusted, and nothing takes its place.",
        path=frame.origin,
        remedy="More sensors that check each other may help; a car stops here.",
    )
