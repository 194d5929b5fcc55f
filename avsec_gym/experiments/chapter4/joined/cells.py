"""Frames of a car with four connected vehicles, some of its sensors attacked: what each side finds.

A cell keeps the probabilities of all sensor state vectors, so that what a report of connected
vehicles is worth can be counted over the places of a run.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from avsec_gym.attacks.sensor_combination import thesis_attack
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter4.procedural_instants import ScannedPlace
from avsec_gym.experiments.chapter4.settings import FIVE, JUDGED
from avsec_gym.experiments.procedural_frames import PROCEDURAL
from avsec_gym.frame import SensorFrame
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, Experiment, Measurement
from avsec_gym.sensor_system import LIDAR, Sensor
from avsec_gym.validation.connected.fit import SHIPPED_FIT
from avsec_gym.validation.connected.frame_validator import OWN, connected_validator, frame_of_scans
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.shipped import shipped_file
from avsec_gym.validation.state_posterior import Decoding, SensorStatus
from avsec_gym.world.capture import render
from avsec_gym.world.motion import later

CASES: Mapping[str, tuple[Sensor, ...]] = {
    "joined none": (),
    "joined lidar": (LIDAR,),
    "joined camera 3": (3,),
    "joined camera 2": (2,),
    "joined lidar, camera 3": (LIDAR, 3),
}
"""Attacked sensors by the setting's name; of three, the thesis' algorithms name none."""
STATUS, ALARM, FAMILIAR, OWN_STATE, RECOVERED_STATE = (
    "status",
    "alarm",
    "familiar",
    "own",
    "recovered",
)
"""Names of measurements; with a number behind the last two: the place of a state vector."""
STATUSES = tuple(SensorStatus)
"""A status is kept as its place here."""
_USUAL_COUNT = 50
_WORK = f"{__name__}:JoinedFrames"


def joined_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every place.

    Raises:
        ConfigurationError: Data other than procedural ones, or a seed that places do not have.
    """
    if configuration.scenarios != PROCEDURAL or not 0 <= configuration.seed < 1000:
        raise ConfigurationError(
            "joined_identification renders places of the procedural world: --scenarios is"
            f" {PROCEDURAL!r} and --seed from 0 to 999, got {configuration.scenarios!r} and"
            f" {configuration.seed}"
        )
    return [Cell.of(_WORK, number=number) for number in range(configuration.limit or _USUAL_COUNT)]


def joined_inputs(configuration: Configuration) -> dict[str, Path]:
    """What both validators were fitted to; no option changes them."""
    return {
        "constants": SHIPPED_FIT,
        "likelihood": shipped_file("likelihood", LIDAR_AND_TWO_CAMERAS),
    }


class JoinedFrames:
    """Attacks the frames of places, and asks the car's own sensors and the connected vehicles.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._seed = configuration.seed
        self._own = LikelihoodValidator(shipped_file("likelihood", LIDAR_AND_TWO_CAMERAS))
        self._others = connected_validator()

    def __call__(self, number: int) -> CellResult:
        """All cases of a place.

        Args:
            number: Number of the place.
        """
        start = time.perf_counter()
        id, frame = self._frame(number)
        seconds = {"render": time.perf_counter() - start}
        rows: list[Measurement] = []
        start = time.perf_counter()
        for case, sensors in CASES.items():
            attack = thesis_attack(sensors, LIDAR_AND_TWO_CAMERAS.reference)
            rows += self._judged(case, id, attack.attack(frame, (self._seed, number)).frame)
        seconds["judge"] = time.perf_counter() - start
        return CellResult(measurements=rows, seconds=seconds)

    def _frame(self, number: int) -> tuple[str, SensorFrame]:
        """The frame of the car at a place, with what the others share, and its id."""
        place = ScannedPlace(self._seed, JUDGED, number, FIVE.vehicles)
        instant = place.instant(FIVE)
        seen = later(place.posed, instant.scans[OWN].time)
        capture = render(seen, ego=OWN, cameras=LIDAR_AND_TWO_CAMERAS.cameras, lidar=None)
        frame = frame_of_scans(instant.id, instant.scans, seen.rig.calibration)
        return instant.id, replace(frame, images=capture.images)

    def _judged(self, case: str, id: str, frame: SensorFrame) -> list[Measurement]:
        judged = self._others.validate(frame)
        own = self._own.decode(frame)
        status = judged.statuses[LIDAR]
        values = {
            STATUS: float(STATUSES.index(status)),
            ALARM: float(own.alarms[0] or judged.alarm),
            **_states(OWN_STATE, own),
        }
        familiar = own
        if status == SensorStatus.ATTACKED:
            familiar = self._own.decode(judged.repaired(frame))
            values |= _states(RECOVERED_STATE, familiar)
        values[FAMILIAR] = float(familiar.familiar[0])
        values[f"{OWN_STATE} {ALARM}"] = float(own.alarms[0])
        values[f"{OWN_STATE} {FAMILIAR}"] = float(own.familiar[0])
        return [Measurement(case, id, name, value) for name, value in values.items()]


def _states(name: str, decoding: Decoding) -> dict[str, float]:
    probabilities = decoding.posterior.probabilities[0].tolist()
    return {f"{name} {index}": value for index, value in enumerate(probabilities)}


JOINED = Experiment(
    "joined_identification",
    "Do connected vehicles name more attacked sensors of a car than it can itself?",
    "",
    joined_cells,
    joined_inputs,
    {},
    Configuration(PROCEDURAL, _USUAL_COUNT),
    section="avsec_gym.experiments.chapter4.joined.section:findings",
)
