"""What detectors see of every attack of the diagrams, frame by frame."""

from __future__ import annotations

import time

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.diagrams.evidence_cells import (
    ATTACKED_CAMERAS,
    CLEAN,
    camera_of,
    clean_name,
    place_seed,
)
from avsec_gym.experiments.chapter3.diagrams.scan_rings import kept_rings, on_rings
from avsec_gym.experiments.chapter3.diagrams.settings import DiagramSettings
from avsec_gym.experiments.chapter3.diagrams.variant import (
    Variant,
    is_of_lidar,
    lit,
    with_bogus_object,
)
from avsec_gym.experiments.chapter3.objects.believed_points import ATTACKED, best_score, score_name
from avsec_gym.experiments.chapter3.objects.detector_weights import (
    image_detector,
    lidar_detector,
    scan_alone,
)
from avsec_gym.experiments.chapter3.objects.frame_truth import truth_of
from avsec_gym.experiments.chapter3.objects.object_mismatches import boxes_seen_by
from avsec_gym.experiments.chapter3.objects.pasted_cars import CarsOfFrames
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    SYSTEM,
    recordings_of,
    seed_of,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.runs.experiment import CellResult, Configuration, DetectionRow, Measurement

WIDTH = "width"
"""Width of the reference's image, pixels."""


def seen_setting(detector: str, part: str, what: str, camera: int) -> str:
    """What boxes are filed under.

    Args:
        detector: Name of the detector.
        part: `FITTED` or `JUDGED`.
        what: `Variant.name`, or `clean_name`.
        camera: The camera in whose image 2D boxes are.
    """
    return f"diagram {detector} {part} {what} in {camera}"


def views_setting(part: str) -> str:
    """What `WIDTH` is filed under; frames of both parts may have one id."""
    return f"diagram {part} views"


def truth_setting(part: str) -> str:
    """What is really there."""
    return f"diagram {part} truth"


def believed_setting(what: str) -> str:
    """What scores at the place of a bogus object are filed under."""
    return f"diagram believed {what}"


class DiagramObjects:
    """Shows every attack to detectors.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        settings = DiagramSettings.of(configuration)
        self._believers = {
            name: lidar_detector(name, settings.weights) for name in settings.believers
        }
        self._image_name = settings.image_detector
        self._image = image_detector(self._image_name, settings.weights)
        self._scans, self._variants = settings.scans, settings.variants()
        self._parts = {part: recordings_of(configuration, part) for part in (FITTED, JUDGED)}
        self._seed = seed_of(configuration, JUDGED)
        self._cars = CarsOfFrames(self._parts[FITTED].frames)
        self._cameras = [int(SYSTEM.sensors[position]) for position in ATTACKED_CAMERAS]

    def __call__(self, part: str, number: int, format: int) -> CellResult:
        """What is found without an attack, and of a judged frame with each.

        Args:
            part: `FITTED`, which is not attacked, or `JUDGED`.
            number: The number of the frame.
            format: `DIAGRAM_FORMAT`; cells of another one are done again.
        """
        recorded = self._parts[part].frames[number]
        frame, id = recorded.frame(), recorded.id
        start = time.perf_counter()
        truth = truth_of(frame, SYSTEM.reference)
        boxes = [] if truth is None else [DetectionRow(truth_setting(part), id, truth)]
        width = float(frame.image(SYSTEM.reference).shape[1])
        rows = [Measurement(views_setting(part), id, WIDTH, width)]
        for camera in self._cameras:
            boxes.append(self._in_image(part, CLEAN, frame, camera, id))
        for most in self._scans:
            rings = kept_rings(frame.points, most)
            thinned = frame.with_points(on_rings(frame.points, rings))
            clean = self._look(thinned)
            boxes += self._in_scan(part, clean_name(most), clean, frame, id)
            if part == FITTED:
                continue
            for variant in (each for each in self._variants if each.scan == most):
                if is_of_lidar(variant):
                    seen, scores = self._bogus(variant, thinned, clean, rings, id, number)
                    boxes, rows = [*boxes, *seen], [*rows, *scores]
                    continue
                camera = int(SYSTEM.sensors[camera_of(number)])
                changed = lit(variant, frame, camera, place_seed(self._seed, number))
                boxes.append(self._in_image(part, variant.name, changed, camera, id))
        seconds = {"objects": time.perf_counter() - start}
        return CellResult(detections=boxes, measurements=rows, seconds=seconds)

    def _bogus(
        self,
        variant: Variant,
        frame: SensorFrame,
        clean: dict[str, Boxes3D],
        rings: frozenset[int] | None,
        id: str,
        number: int,
    ) -> tuple[list[DetectionRow], list[Measurement]]:
        car = self._cars.first_of(range(number, number + len(self._parts[FITTED].frames)))
        bogus = with_bogus_object(variant, frame, car, rings, place_seed(self._seed, number))
        if bogus is None:
            return [], []
        attacked = self._look(bogus.tampered.frame)
        scores = [
            Measurement(
                believed_setting(variant.name),
                id,
                score_name(name, state),
                best_score(found[name], bogus.place),
            )
            for state, found in ((ATTACKED, attacked), (CLEAN, clean))
            for name in self._believers
        ]
        first = {name: attacked[name] for name in [*self._believers][:1]}
        return self._in_scan(JUDGED, variant.name, first, frame, id), scores

    def _look(self, frame: SensorFrame) -> dict[str, Boxes3D]:
        alone = scan_alone(frame)
        return {name: detector.detect(alone) for name, detector in self._believers.items()}

    def _in_scan(
        self, part: str, what: str, found: dict[str, Boxes3D], frame: SensorFrame, id: str
    ) -> list[DetectionRow]:
        rows = []
        for name, boxes in found.items():
            for camera in self._cameras:
                size = frame.image(camera).shape[:2]
                seen = boxes_seen_by(boxes, frame.calibration.projection(camera), size)
                rows.append(DetectionRow(seen_setting(name, part, what, camera), id, seen))
        return rows

    def _in_image(
        self, part: str, what: str, frame: SensorFrame, camera: int, id: str
    ) -> DetectionRow:
        found = self._image.detect(frame, camera)
        return DetectionRow(seen_setting(self._image_name, part, what, camera), id, found)
