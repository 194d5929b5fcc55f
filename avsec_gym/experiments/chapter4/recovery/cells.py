"""Episodes of a car whose scan is attacked, alone and with what connected vehicles give back."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter4.procedural_instants import ScannedPlace
from avsec_gym.experiments.chapter4.recovery.driven_instant import DrivenInstant, scene_around
from avsec_gym.experiments.chapter4.settings import FIVE, JUDGED
from avsec_gym.experiments.procedural_frames import PROCEDURAL
from avsec_gym.pipeline import Pipeline
from avsec_gym.registry import Kind, make
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    EpisodeRow,
    Experiment,
)
from avsec_gym.scenario.scene import Motion
from avsec_gym.validation.connected.attacks.attacked_instant import InstantAttack
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.attacks.removed_object import RemovedObject
from avsec_gym.validation.connected.fit import SHIPPED_FIT
from avsec_gym.validation.connected.frame_validator import OWN, connected_validator
from avsec_gym.validation.response import Response

Case = Literal["clean", "ghost", "removal"]
Car = Literal["alone", "connected"]
CLEAN: Case = "clean"
KNOWN = "truth"
"""The setting of a car that knows all; the others are such as ``pixor ghost connected``."""
OPTIONS = {"detector": "pixor", "constants": "", "alarms": 0.1, "score_threshold": 0.3}
"""``detector``: one that reads scans; ``constants``: a file that `avsec connected --fit` wrote, the
package's own if empty; ``alarms``: share of attack-free instants that may alarm."""
_USUAL_COUNT = 100
_ATTACKS: Mapping[Case, InstantAttack] = {
    "ghost": PastedObject(vehicle=OWN, distance=(6.0, 20.0), bearing=0.0),
    "removal": RemovedObject(vehicle=OWN),
}
"""A ghost straight ahead, and whatever the car sees."""
_WORK = f"{__name__}:RecoveredEpisodes"


def recovery_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every place.

    Raises:
        ConfigurationError: Data other than procedural ones, or a seed that places do not have.
    """
    if configuration.scenarios != PROCEDURAL or not 0 <= configuration.seed < 1000:
        raise ConfigurationError(
            f"connected_recovery drives at places of the procedural world: --scenarios is"
            f" {PROCEDURAL!r} and --seed from 0 to 999, got {configuration.scenarios!r} and"
            f" {configuration.seed}"
        )
    return [Cell.of(_WORK, number=number) for number in range(configuration.limit or _USUAL_COUNT)]


def recovery_inputs(configuration: Configuration) -> dict[str, Path]:
    """The fit that the evidence is weighed by."""
    given = {**OPTIONS, **configuration.options}["constants"]
    return {"constants": Path(given) if given else SHIPPED_FIT}


class RecoveredEpisodes:
    """Drives at places: alone and connected, attacked and not.

    Args:
        configuration: The configuration of the run.

    Raises:
        ConfigurationError: There is no such detector.
        DataError: The file of constants is missing or damaged.
    """

    def __init__(self, configuration: Configuration) -> None:
        options = {**OPTIONS, **configuration.options}
        self._seed = configuration.seed
        detector = make(Kind.DETECTOR, options["detector"])
        constants = recovery_inputs(configuration)["constants"]
        validator = connected_validator(constants=constants, alarms=options["alarms"])
        self._name = str(detector.name)
        self._cars: dict[str, Pipeline] = {
            "alone": self._car(detector, options),
            "connected": self._car(detector, options, validator=validator),
        }

    def __call__(self, number: int) -> CellResult:
        """All episodes of a place.

        Args:
            number: Number of the place.
        """
        start = time.perf_counter()
        place = ScannedPlace(self._seed, JUDGED, number, FIVE.vehicles)
        # The usual errors of poses and clocks, with five vehicles.
        instant, posed = place.instant(FIVE), place.posed
        assert instant.truth is not None
        calibration, road_type = posed.rig.calibration, posed.site.road_type
        pose = instant.true_pose(OWN)
        scene = scene_around(
            instant.truth, pose, calibration, id=instant.id, road_type=road_type, number=number
        )
        driven = DrivenInstant(scene, calibration)
        seconds = {"scan": time.perf_counter() - start}

        rows = [EpisodeRow(KNOWN, record) for record in driven.known(self._cars["alone"])]
        cases = {CLEAN: instant}
        for index, (kind, attack) in enumerate(_ATTACKS.items()):
            attacked = attack.attack(instant, (self._seed, number, index))
            if attacked is not None:
                cases[kind] = attacked.instant
        for case, tampered in cases.items():
            start = time.perf_counter()
            for car, records in driven.driven(self._cars, tampered).items():
                rows += [EpisodeRow(f"{self._name} {case} {car}", record) for record in records]
            seconds[f"drive {case}"] = time.perf_counter() - start
        return CellResult(rows, seconds=seconds)

    def _car(self, detector: object, options: Mapping[str, object], **parts: object) -> Pipeline:
        return Pipeline(
            detector,
            motion=Motion.TRUTH,
            score_threshold=float(str(options["score_threshold"])),
            response=Response.REPAIR,
            **parts,  # type: ignore[arg-type]
        )


RECOVERY = Experiment(
    "connected_recovery",
    "What do recovered scans save: collisions, and needless stops?",
    "",
    recovery_cells,
    recovery_inputs,
    OPTIONS,
    Configuration(PROCEDURAL, _USUAL_COUNT),
    section="avsec_gym.experiments.chapter4.recovery.section:findings",
)
