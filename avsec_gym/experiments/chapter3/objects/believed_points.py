"""Which bogus points does a detector take for an obstacle?  Planes, and scans of real cars.

The thesis attacks with planes, since chapter 3 compares sensors with each other; its section 4.5
pastes scans of objects.  Here all stand at one place, so that what they look like alone differs.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.objects.bogus_obstacles import bogus_patch, covering
from avsec_gym.experiments.chapter3.objects.detector_weights import (
    WEIGHT_OPTIONS,
    lidar_detector,
    scan_alone,
    weight_inputs,
)
from avsec_gym.experiments.chapter3.objects.frame_truth import truth_of
from avsec_gym.experiments.chapter3.objects.object_mismatches import boxes_seen_by
from avsec_gym.experiments.chapter3.objects.pasted_cars import (
    CarInView,
    CarsOfFrames,
    pasted_box,
)
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    PART_OPTIONS,
    SYSTEM,
    drives_inputs,
    frame_cells,
    recordings_of,
    seed_of,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    Measurement,
)

PLANE, PLANE_RAYS_LOST, PLANE_OF_A_CAR = "plane", "plane, rays lost", "plane of a car"
PASTED, PASTED_RAYS_LOST = "car", "car, rays lost"
PLANES = {
    PLANE: LidarSpoofing(reference=SYSTEM.reference),
    PLANE_RAYS_LOST: LidarSpoofing(reference=SYSTEM.reference, rays_lost=True),
    PLANE_OF_A_CAR: LidarSpoofing(width=1.7, reference=SYSTEM.reference, rays_lost=True),
}
"""The thesis' bogus return, one that hides what is behind it, and one as wide as a car's rear."""
CARS = {PASTED: False, PASTED_RAYS_LOST: True}
"""Scans of cars: whether they hide what is behind them."""
BELIEVED_OPTIONS = {
    **PART_OPTIONS,
    "believers": "pixor,pointrcnn",
    **{name: WEIGHT_OPTIONS[name] for name in ("pixor", "pointrcnn")},
}
"""Beside `PART_OPTIONS`: ``believers``: detectors that look at scans, with commas; by the
networks' names their weights."""
ATTACKED, CLEAN = "attacked", "clean"
TRUTH = "believed truth"
_WORK = f"{__name__}:BelievedPoints"


def believed_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every frame, first the clean ones, whose cars are pasted into the others."""
    return frame_cells(_WORK, configuration, (FITTED, JUDGED))


def believed_inputs(configuration: Configuration) -> dict[str, Path]:
    """Weights, and the manifests of procedural drives."""
    options = {**BELIEVED_OPTIONS, **configuration.options}
    found = weight_inputs(options["believers"].split(","), options)
    return found | drives_inputs(configuration, (FITTED, JUDGED))


def found_setting(detector: str) -> str:
    """What clean detections are filed under, on which scores are chosen."""
    return f"believed by {detector}"


def believed_setting(kind: str) -> str:
    """What scores are filed under."""
    return f"believed {kind}"


def score_name(detector: str, state: str) -> str:
    """The best score of a box at the bogus points' place, in the `ATTACKED` or the `CLEAN` scan."""
    return f"{detector} {state}"


class BelievedPoints:
    """Shows bogus points to detectors.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        options = {**BELIEVED_OPTIONS, **configuration.options}
        self._detectors = {
            name: lidar_detector(name, options) for name in options["believers"].split(",")
        }
        self._parts = {part: recordings_of(configuration, part) for part in (FITTED, JUDGED)}
        self._seed = seed_of(configuration, JUDGED)
        self._cars = CarsOfFrames(self._parts[FITTED].frames)

    def __call__(self, part: str, number: int) -> CellResult:
        """Of a fitted frame what is found, and the truth; of a judged one scores by kind.

        A score is NaN where no box is; without a labelled car there are planes only.

        Args:
            part: `FITTED` or `JUDGED`.
            number: The number of the frame.
        """
        recorded = self._parts[part].frames[number]
        frame = recorded.frame()
        seconds = dict.fromkeys(("attack", *self._detectors), 0.0)
        if part == FITTED:
            camera = SYSTEM.reference
            view = frame.calibration.projection(camera), frame.image(camera).shape[:2]
            boxes = {
                found_setting(name): boxes_seen_by(found, *view)
                for name, found in self._look(frame, seconds).items()
            }
            truth = truth_of(frame, camera)
            boxes |= {} if truth is None else {TRUTH: truth}
            rows = [DetectionRow(setting, recorded.id, found) for setting, found in boxes.items()]
            return CellResult(detections=rows, seconds=seconds)
        clean = self._look(frame, seconds)
        scores: list[Measurement] = []
        begun = time.perf_counter()
        for kind, tampered, place in self._attacked(frame, number):
            seconds["attack"] += time.perf_counter() - begun
            attacked = self._look(tampered.frame, seconds)
            scores += [
                Measurement(
                    believed_setting(kind),
                    recorded.id,
                    score_name(name, state),
                    best_score(found[name], place),
                )
                for state, found in ((ATTACKED, attacked), (CLEAN, clean))
                for name in self._detectors
            ]
            begun = time.perf_counter()
        return CellResult(measurements=scores, seconds=seconds)

    def _attacked(
        self, frame: SensorFrame, number: int
    ) -> Iterator[tuple[str, TamperedFrame, Boxes3D]]:
        """By kind the frame, and the place of the bogus points."""
        seed = (self._seed, number)
        distance, bearing = PLANES[PLANE].place(frame, seed)
        for kind, plane in PLANES.items():
            tampered = replace(plane, distance=distance, bearing=bearing).attack(frame, seed)
            yield kind, tampered, bogus_patch(tampered)
        count = len(self._parts[FITTED].frames)
        scan = self._cars.first_of(range(number, number + count))
        if scan is None:
            return
        for kind, rays_lost in CARS.items():
            tampered = CarInView(scan, SYSTEM.reference, rays_lost).attack(frame, seed)
            yield kind, tampered, pasted_box(scan, tampered)

    def _look(self, frame: SensorFrame, seconds: dict[str, float]) -> dict[str, Boxes3D]:
        found = {}
        for name, detector in self._detectors.items():
            begun = time.perf_counter()
            found[name] = detector.detect(scan_alone(frame))
            seconds[name] += time.perf_counter() - begun
        return found


def best_score(found: Boxes3D, place: Boxes3D) -> float:
    """The highest of the boxes that cover a place; NaN where none does."""
    scores = found.score[covering(found, place)]
    return float(scores.max()) if len(scores) else math.nan
