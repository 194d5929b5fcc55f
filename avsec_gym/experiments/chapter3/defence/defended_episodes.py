"""What is a validator before the detector worth?  Episodes with and without attack and defence.

Every frame of the judged drives is one situation.  An attack begins with a drive's first frame and
stays as it is: the same spot of light, the same bogus return.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from pathlib import Path

from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.attacks.sensor_combination import attack_cases, thesis_attack
from avsec_gym.experiments.chapter3.defence.oracles import (
    LIDAR_ORACLE,
    STEREO_ORACLE,
    LidarOracle,
    StereoOracle,
)
from avsec_gym.experiments.chapter3.defence.scenes import scene_of
from avsec_gym.experiments.chapter3.defence.validator import (
    VALIDATOR_OPTIONS,
    defending_validator,
    fitted_file,
)
from avsec_gym.experiments.chapter3.objects.detector_weights import weight_inputs, weights_of
from avsec_gym.experiments.chapter3.recordings import JUDGED, USUAL_COUNT, recordings_of
from avsec_gym.experiments.procedural_frames import PROCEDURAL
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.pipeline import Perception, Pipeline
from avsec_gym.registry import Kind, make
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    EpisodeRow,
    Experiment,
    Measurement,
)
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem
from avsec_gym.validation.recordings import Recordings, drive_of
from avsec_gym.validation.response import Response
from avsec_gym.validation.state_posterior import SensorStatus

NO_ATTACK, UNDEFENDED = "none", "undefended"
"""The names that settings have for them: ``oracle none undefended``, ``stereo_rcnn lidar+3
drop``."""
ORACLES = (STEREO_ORACLE, LIDAR_ORACLE)
OPTIONS = {
    **VALIDATOR_OPTIONS,
    "detectors": ",".join(ORACLES),
    "attacked_at_once": 1,
    "motion": "truth",
    "score_threshold": 0.3,
    "dsgn": "",
    "stereo_rcnn": "",
    "pixor": "",
    "pointrcnn": "",
}
"""Options beside those of the validator: ``detectors``: names with commas; ``attacked_at_once``:
how many sensors at most, none and one alone if 1; ``motion``: see `Motion`; by the networks' names
their weights, instead of those of the package."""

DRIVE_FRAMES = 4
"""Drive frames of procedural drives: what the first frame hides of an attack the next ones may
show. Frames of one drive are little more evidence than one frame, and take as long to render as new
roads."""

_WORK = f"{__name__}:DefendedEpisodes"


def defence_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every frame and attack, drive by drive."""
    recordings = _judged(configuration)
    at_once = {**OPTIONS, **configuration.options}["attacked_at_once"]
    return [
        Cell.of(_WORK, drive_of(recorded.id), attack=attack, number=number)
        for number, recorded in enumerate(recordings.frames)
        for attack in attacks_on(recordings.system, at_once)
    ]


def defence_inputs(configuration: Configuration) -> dict[str, Path]:
    """The manifest of procedural drives, what the validator was fitted to, and weights."""
    options = {**OPTIONS, **configuration.options}
    networks = [name for name in options["detectors"].split(",") if name not in ORACLES]
    weights = weight_inputs(networks, options)
    manifest = _judged(configuration).root / "manifest.json"
    drives = {f"{JUDGED} drives": manifest} if manifest.is_file() else {}
    return {**drives, "validator": fitted_file(configuration), **weights}


def attacks_on(system: SensorSystem, at_once: int) -> list[str]:
    """`NO_ATTACK`, then every set of up to so many sensors: ``lidar``, ``3``, ``lidar+3``."""
    cases = attack_cases(system, at_once) if at_once else ()
    return [NO_ATTACK, *("+".join(map(str, case)) for case in cases)]


def _judged(configuration: Configuration) -> Recordings:
    return recordings_of(configuration, JUDGED, DRIVE_FRAMES)


class DefendedEpisodes:
    """Attacks a frame, asks the validator, and drives: undefended, and with each response.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._options = {**OPTIONS, **configuration.options}
        self._seed = configuration.seed
        self._recordings = _judged(configuration)
        self._drives = sorted({drive_of(recorded.id) for recorded in self._recordings.frames})
        self._validator = defending_validator(configuration)
        self._networks = {
            name: self._network(name)
            for name in self._options["detectors"].split(",")
            if name not in ORACLES
        }

    def __call__(self, attack: str, number: int) -> CellResult:
        """Episodes of every detector, response and intention; the alarm, and the named sensors.

        A sensor is ``named`` by 1, or 0; NaN: its status is open.

        Args:
            attack: The name of the attack, see `attacks_on`.
            number: The number of the frame.
        """
        recorded, seconds = self._recordings.frames[number], {}
        clean = recorded.frame()
        scene = scene_of(clean, recorded.id, number, self._seed)
        start = time.perf_counter()
        tampered = self._tampered(attack, clean, recorded.id)
        seconds["attack"] = time.perf_counter() - start
        start = time.perf_counter()
        validation = self._validator.validate(tampered.frame)
        seconds["validator"] = time.perf_counter() - start
        measurements = [Measurement(attack, recorded.id, "alarm", float(validation.alarm))]
        for sensor, status in validation.statuses.items():
            named = (
                math.nan
                if status == SensorStatus.CANNOT_TELL
                else float(status == SensorStatus.ATTACKED)
            )
            measurements.append(Measurement(attack, recorded.id, f"named {sensor}", named))
        episodes: list[EpisodeRow] = []
        for detector in self._detectors(clean, scene, tampered):
            undefended = self._pipeline(detector)
            seen = undefended.perceive(tampered.frame)
            episodes += _driven(undefended, scene, seen, f"{detector.name} {attack} {UNDEFENDED}")
            for response in Response:
                pipeline = self._pipeline(detector, response)
                # Without alarm, the defended car believes what the other one does.
                believed = (
                    pipeline.perceive(tampered.frame, validation) if validation.alarm else seen
                )
                episodes += _driven(
                    pipeline, scene, believed, f"{detector.name} {attack} {response}"
                )
        return CellResult(episodes, measurements=measurements, seconds=seconds)

    def _tampered(self, attack: str, clean: SensorFrame, id: str) -> TamperedFrame:
        if attack == NO_ATTACK:
            return TamperedFrame(clean)
        sensors: list[Sensor] = [
            sensor if sensor == LIDAR else int(sensor) for sensor in attack.split("+")
        ]
        seed = (self._seed, 1 + self._drives.index(drive_of(id)))
        return thesis_attack(sensors, self._recordings.system.reference).attack(clean, seed)

    def _detectors(
        self, clean: SensorFrame, scene: Scene, tampered: TamperedFrame
    ) -> Iterator[Detector]:
        bogus = tampered.points
        for name in self._options["detectors"].split(","):
            if name == STEREO_ORACLE:
                yield StereoOracle(clean, scene.boxes)
            elif name == LIDAR_ORACLE:
                points = tampered.frame.points
                yield LidarOracle(points[:0] if bogus is None else points[bogus], scene.boxes)
            else:
                yield self._networks[name]

    def _network(self, name: str) -> Detector:
        known = {"weights": weights_of(name, self._options)} if name in self._options else {}
        detector: Detector = make(Kind.DETECTOR, {"name": name, **known})
        return detector

    def _pipeline(self, detector: Detector, response: Response | None = None) -> Pipeline:
        return Pipeline(
            detector,
            motion=Motion.named(self._options["motion"]),
            score_threshold=self._options["score_threshold"],
            validator=None if response is None else self._validator,
            response=response or Response.STOP,
        )


def _driven(
    pipeline: Pipeline, scene: Scene, believed: Perception, setting: str
) -> Iterator[EpisodeRow]:
    for intention in Intention:
        yield EpisodeRow(setting, pipeline.run_episode(scene, believed, intention).record)


DEFENCE = Experiment(
    "defence",
    "What is a validator before the detector worth: collisions avoided, against false stops?",
    "",
    defence_cells,
    defence_inputs,
    OPTIONS,
    Configuration(PROCEDURAL, USUAL_COUNT),
    section="avsec_gym.experiments.chapter3.defence.section:findings",
)
