"""`FrameValidator`: a car's LiDAR judged by what connected vehicles around it scan (chapter 4).

It stands before the detector, as validators of one car's sensors do: a frame in, the LiDAR's status
out.  To the base station the car is vehicle `OWN` among the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np

from avsec_gym.argument_checks import number
from avsec_gym.connected_scans import ConnectedScans, ScanPose, SharedScan
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.compromised_sensors import without_compromised_sensors
from avsec_gym.validation.connected.fit import ConnectedFit
from avsec_gym.validation.connected.named_validators import fit_in
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL
from avsec_gym.validation.connected.recovery import recovered_scan
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import RepairingJudgement

OWN = 0
"""The number of the car among the vehicles of the instant."""


@dataclass(frozen=True, eq=False)
class ConnectedJudgement(RepairingJudgement):
    """The status of a car's LiDAR by connected vehicles.

    Args:
        alarm: Whether the car's own LiDAR is, or may be, attacked.
        statuses: The LiDAR's status: attacked where the car is named; open where a region alarms of
            which it cannot be decided whose LiDAR is attacked, and it may be the car's.
        result: What vehicles and base station made of the instant.
        scan: The car's own scan, as it was judged.
    """

    result: ConnectedResult
    scan: VehicleScan

    def repaired(self, frame: SensorFrame) -> SensorFrame:
        """The frame with the scan that the others give back, see `recovered_scan`.

        Where the status is open there is nothing to recover, and no one may ask for the scan.
        """
        if self.statuses[LIDAR] != SensorStatus.ATTACKED:
            return without_compromised_sensors(frame, self)
        return frame.with_points(recovered_scan(self.scan, OWN, self.result).points)


@dataclass(frozen=True, eq=False)
class FrameValidator:
    """Judges the LiDAR of a frame by the scans that other vehicles share beside it.

    Args:
        fit: What the evidence of rays is worth.
        alarms: Share of attack-free instants in which some region may alarm.

    Raises:
        ConfigurationError: No such share.
    """

    name: ClassVar[str] = "connected"
    fit: ConnectedFit
    alarms: float = 0.1

    def __post_init__(self) -> None:
        object.__setattr__(self, "alarms", number("alarms", self.alarms, 0.0, 1.0))

    @cached_property
    def validator(self) -> ConnectedValidator:
        """Vehicles and base station, by evidence of rays."""
        return ConnectedValidator(self.fit.constants(alarms=self.alarms))

    def validate(self, frame: SensorFrame) -> ConnectedJudgement:
        """Judge one frame.

        Args:
            frame: A frame with a scan and with `SensorFrame.connected`.

        Raises:
            ConfigurationError: The fit is of another LiDAR than the others have.
            DataError: The frame has no scan, or no other vehicle shares one.
        """
        scans = vehicle_scans(frame)
        # A rig is recognised by scans that no attack on this car reaches.
        self.fit.check(scans[OWN + 1 :])
        result = self.validator.validate(scans, id=frame.id)
        status = _status(result, 1.0 - self.validator.constants.rule.certain)
        return ConnectedJudgement(status != SensorStatus.SOUND, {LIDAR: status}, result, scans[OWN])


def connected_validator(
    *, constants: str | Path | None = None, alarms: float = 0.1
) -> FrameValidator:
    """The validator ``connected`` of a car's frame.

    Args:
        constants: A file of `avsec connected --fit`; None: the package's own.
        alarms: Share of attack-free instants in which some region may alarm.

    Raises:
        ConfigurationError: No such share, or no name of a file.
        DataError: The file is missing or damaged.
    """
    return FrameValidator(fit_in(constants), alarms)


def frame_of_scans(id: str, scans: Sequence[VehicleScan], calibration: Calibration) -> SensorFrame:
    """The frame of vehicle `OWN` of an instant, what the others share beside it.

    Args:
        id: Id of the frame.
        scans: The scan of each vehicle, by number.
        calibration: The calibration of the vehicle's sensors.
    """
    places = [
        ScanPose(scan.pose, scan.time, **vars(scan.sweep), roadside=scan.roadside) for scan in scans
    ]
    others = [
        SharedScan(scan.points, place)
        for number, (scan, place) in enumerate(zip(scans, places, strict=True))
        if number != OWN
    ]
    neighbours = ConnectedScans(places[OWN], tuple(others))
    return SensorFrame(id, calibration, scan=scans[OWN].points, neighbours=neighbours)


def vehicle_scans(frame: SensorFrame) -> list[VehicleScan]:
    """The scans of an instant as vehicles hold them, the car's own first.

    Raises:
        DataError: The frame has no scan, or no other vehicle shares one.
    """
    connected = frame.connected
    shared = [(frame.points, connected.own)]
    for other in connected.others:
        points = other.points() if callable(other.points) else other.points
        shared.append((points, other.place))
    return [
        VehicleScan(
            points,
            place.pose,
            place.time,
            RollingSweep(place.speed, place.turn_rate, place.period),
            place.roadside,
        )
        for points, place in shared
    ]


def _status(result: ConnectedResult, doubt: float) -> SensorStatus:
    """The status of the car's LiDAR.

    Args:
        result: What was decided of the instant.
        doubt: The probability, if there is an attack, up to which it is not the car's LiDAR.
    """
    if OWN in result.accused:
        return SensorStatus.ATTACKED
    own = result.ghost[:, OWN] + result.removal[:, OWN]
    is_open = (result.named == CANNOT_TELL) & (own > doubt)
    return SensorStatus.CANNOT_TELL if np.any(is_open) else SensorStatus.SOUND
