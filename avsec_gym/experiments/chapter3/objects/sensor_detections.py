"""What detectors see of each sensor, clean and attacked: the work of the baseline and the impact.

Each sensor is looked at alone: a LiDAR's detector gets no image.  Attacks are those that chapter 3
is judged on, of the same draws as in `identification`.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from itertools import product
from pathlib import Path

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.attacks import tampered_frames
from avsec_gym.experiments.chapter3.objects.bogus_obstacles import bogus_patch
from avsec_gym.experiments.chapter3.objects.detector_weights import (
    WEIGHT_OPTIONS,
    image_detector,
    lidar_detector,
    weight_inputs,
)
from avsec_gym.experiments.chapter3.objects.moment_truth import truth_of
from avsec_gym.experiments.chapter3.objects.object_mismatches import (
    boxes_seen_by,
    disparity_reach,
    mismatches,
)
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    OPTIONS,
    drives_inputs,
    moment_cells,
    recordings_of,
)
from avsec_gym.experiments.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    Measurement,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem
from avsec_gym.validation.moments import Recordings

IOUS = (0.5, 0.7)
"""That partners have more in common than."""
DETECTION_OPTIONS = {
    "fit": OPTIONS["fit"],
    "fit_limit": OPTIONS["fit_limit"],
    "fit_seed": OPTIONS["fit_seed"],
    "lidar_detector": "pixor",
    "image_detector": "faster_rcnn",
    "score_threshold": 0.3,
    **{name: WEIGHT_OPTIONS[name] for name in ("pixor", "faster_rcnn")},
}
"""``fit``, ``fit_limit``, ``fit_seed``: see `recordings.OPTIONS`; ``lidar_detector`` and
``image_detector``: who looks; ``score_threshold``: of boxes that count as objects; by the networks'
names their weights."""
TRUTH, PATCH = "judged truth", "judged bogus patch"
"""Settings of what is really there, and of where bogus points stand."""

Seen = dict[tuple[Sensor, int, bool], Boxes3D]
"""By sensor, camera in whose image 2D boxes are, and whether the sensor was attacked."""

_WORK = f"{__name__}:SensorDetections"


def baseline_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every moment, first the clean ones that thresholds are fitted on."""
    return moment_cells(_WORK, configuration, (FITTED, JUDGED))


def impact_cells(configuration: Configuration) -> list[Cell]:
    """Those of the judged moments."""
    return moment_cells(_WORK, configuration, (JUDGED,))


def baseline_inputs(configuration: Configuration) -> dict[str, Path]:
    """Weights, and the manifests of procedural drives."""
    return _inputs(configuration, (FITTED, JUDGED))


def impact_inputs(configuration: Configuration) -> dict[str, Path]:
    """The same without the drives to fit on."""
    return _inputs(configuration, (JUDGED,))


def seen_setting(part: str, sensor: Sensor, attacked: bool, camera: int) -> str:
    """What detections are filed under: ``judged lidar attacked in 2``.

    Args:
        part: `FITTED` or `JUDGED`.
        sensor: Whose data were looked at.
        attacked: Whether it was attacked.
        camera: In whose image 2D boxes are; a camera's are in its own.
    """
    return f"{part} {sensor} {'attacked' if attacked else 'clean'} in {camera}"


def mismatch_name(pair: tuple[int, int], iou: float) -> str:
    """What mismatches of two sensors are called: ``mismatches 0.5 0,2``."""
    return f"mismatches {iou:g} {pair[0]},{pair[1]}"


def mismatch_setting(part: str, attacked: Sequence[bool]) -> str:
    """Which of the two were attacked: ``judged 01``."""
    return f"{part} {''.join(str(int(one)) for one in attacked)}"


class SensorDetections:
    """Looks at every sensor of a moment, and counts mismatches of every pair.

    Args:
        configuration: Of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._options = {**DETECTION_OPTIONS, **configuration.options}
        self._lidar = lidar_detector(self._options["lidar_detector"], self._options)
        self._image = image_detector(self._options["image_detector"], self._options)
        self._configuration = configuration
        self._parts: dict[str, Recordings] = {}

    def __call__(self, part: str, number: int) -> CellResult:
        """Detections of each sensor, mismatches of each pair in each state, and the truth.

        Args:
            part: `FITTED`, which nobody attacks, or `JUDGED`.
            number: Of the moment.
        """
        if part not in self._parts:
            self._parts[part] = recordings_of(self._configuration, part)
        recordings = self._parts[part]
        moment, system = recordings.moments[number], recordings.system
        frame = moment.frame()
        seconds = dict.fromkeys(("attack", "lidar detector", "image detector"), 0.0)
        looks: list[tuple[Sensor, bool, SensorFrame]] = [
            (sensor, False, frame) for sensor in system.sensors
        ]
        detections = []
        if part == JUDGED:
            start = time.perf_counter()
            seed = (self._configuration.seed, number)
            attacked = tampered_frames(frame, system, part, seed)
            seconds["attack"] = time.perf_counter() - start
            looks += [(sensor, True, one.frame) for sensor, one in attacked.items()]
            detections.append(DetectionRow(PATCH, moment.id, bogus_patch(attacked[LIDAR])))
            truth = truth_of(frame, system.reference)
            detections += [DetectionRow(TRUTH, moment.id, truth)] if truth is not None else []
        seen: Seen = {}
        for sensor, state, source in looks:
            start = time.perf_counter()
            found = self._look(sensor, source)
            kind = "lidar detector" if sensor == LIDAR else "image detector"
            seconds[kind] += time.perf_counter() - start
            for camera in system.cameras if sensor == LIDAR else (int(sensor),):
                boxes = _seen_by(found, frame, camera) if sensor == LIDAR else found
                seen[sensor, camera, state] = boxes
                setting = seen_setting(part, sensor, state, camera)
                detections.append(DetectionRow(setting, moment.id, boxes))
        least = self._options["score_threshold"]
        objects = {key: boxes[boxes.score >= least] for key, boxes in seen.items()}
        rows = [
            Measurement(mismatch_setting(part, state), moment.id, mismatch_name(pair, iou), count)
            for pair in system.pairs()
            for (state, iou), count in _mismatches(objects, pair, system, frame).items()
        ]
        return CellResult(detections=detections, measurements=rows, seconds=seconds)

    def _look(self, sensor: Sensor, frame: SensorFrame) -> Boxes3D:
        if sensor == LIDAR:
            alone = SensorFrame(frame.id, frame.calibration, scan=frame.points, origin=frame.origin)
            return self._lidar.detect(alone)
        return self._image.detect(frame, int(sensor))


def _mismatches(
    objects: Seen, pair: tuple[int, int], system: SensorSystem, frame: SensorFrame
) -> dict[tuple[tuple[bool, bool], float], int]:
    """Of two sensors, in every state of both and at every IoU."""
    other, camera = system.sensors[pair[0]], int(system.sensors[pair[1]])
    place, reach = camera, 0.0
    if other != LIDAR:
        place = int(other)
        reach = disparity_reach(frame.calibration, camera, place)
    return {
        ((first, second), iou): mismatches(
            objects[camera, camera, second], objects[other, place, first], iou, reach
        )
        for first, second in product((False, True), repeat=2)
        if (other, place, first) in objects and (camera, camera, second) in objects
        for iou in IOUS
    }


def _seen_by(boxes: Boxes3D, frame: SensorFrame, camera: int) -> Boxes3D:
    height, width = frame.image(camera).shape[:2]
    return boxes_seen_by(boxes, frame.calibration.projection(camera), (height, width))


def _inputs(configuration: Configuration, parts: Sequence[str]) -> dict[str, Path]:
    options = {**DETECTION_OPTIONS, **configuration.options}
    # First what may lack, then what may take hours to be made.
    found = weight_inputs((options["lidar_detector"], options["image_detector"]), options)
    return found | drives_inputs(configuration, parts)
