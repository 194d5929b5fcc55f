"""What detectors see of each sensor, clean and attacked: the work of the baseline and the impact.

Each sensor is looked at alone: a LiDAR's detector gets no image.  Attacks are those that chapter 3
is judged on, of the same draws as in `identification`.  Boxes are kept with all their scores: which
of them count as objects is for the summaries.
"""

from __future__ import annotations

import time
from pathlib import Path

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.attacks import tampered_frames
from avsec_gym.experiments.chapter3.objects.bogus_obstacles import bogus_patch
from avsec_gym.experiments.chapter3.objects.detector_weights import (
    WEIGHT_OPTIONS,
    image_detector,
    lidar_detector,
    scan_alone,
    weight_inputs,
)
from avsec_gym.experiments.chapter3.objects.frame_truth import truth_of
from avsec_gym.experiments.chapter3.objects.object_mismatches import (
    boxes_seen_by,
    disparity_reach,
)
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    PART_OPTIONS,
    drives_inputs,
    frame_cells,
    recordings_of,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    Measurement,
)
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem
from avsec_gym.validation.recordings import Recordings

DETECTION_OPTIONS = {
    **PART_OPTIONS,
    "lidar_detector": "pixor",
    "image_detector": "faster_rcnn",
    "score_threshold": 0.0,
    **{name: WEIGHT_OPTIONS[name] for name in ("pixor", "faster_rcnn")},
}
"""Beside `PART_OPTIONS`: ``lidar_detector`` and ``image_detector``: the detectors;
``score_threshold``: of boxes that count as objects, 0 for that score at which each detector finds
most for its false alarms on the clean frames that are fitted on; by the networks' names their
weights."""
PATCH = "judged bogus patch"
"""Setting of where bogus points stand."""
DETECTIONS_FORMAT = 2
"""Raised when something else is looked at or kept."""

_WORK = f"{__name__}:SensorDetections"


def detection_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every frame, first the clean ones that thresholds are fitted on."""
    return frame_cells(_WORK, configuration, (FITTED, JUDGED), format=DETECTIONS_FORMAT)


def detection_inputs(configuration: Configuration) -> dict[str, Path]:
    """Weights, and the manifests of procedural drives."""
    options = {**DETECTION_OPTIONS, **configuration.options}
    # First what may lack, then what may take hours to be made.
    found = weight_inputs((options["lidar_detector"], options["image_detector"]), options)
    return found | drives_inputs(configuration, (FITTED, JUDGED))


def truth_setting(part: str) -> str:
    """What is really there: ``judged truth``."""
    return f"{part} truth"


def view_setting(part: str) -> str:
    """What two cameras can see of one thing: ``judged views``."""
    return f"{part} views"


def reach_name(pair: tuple[int, int]) -> str:
    """The largest disparity of two sensors, pixels: ``reach 1,3``; and see `WIDTH`."""
    return f"reach {pair[0]},{pair[1]}"


WIDTH = "width"
"""Width of the reference's image, pixels."""


def seen_setting(part: str, sensor: Sensor, attacked: bool, camera: int) -> str:
    """What detections are filed under: ``judged lidar attacked in 2``.

    Args:
        part: `FITTED` or `JUDGED`.
        sensor: The sensor whose data were looked at.
        attacked: Whether it was attacked.
        camera: The camera in whose image 2D boxes are; a camera's are in its own.
    """
    return f"{part} {sensor} {'attacked' if attacked else 'clean'} in {camera}"


class SensorDetections:
    """Looks at every sensor of a frame.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._options = {**DETECTION_OPTIONS, **configuration.options}
        self._lidar = lidar_detector(self._options["lidar_detector"], self._options)
        self._image = image_detector(self._options["image_detector"], self._options)
        self._configuration = configuration
        self._parts: dict[str, Recordings] = {}

    def __call__(self, part: str, number: int, format: int) -> CellResult:
        """Detections of each sensor, and the truth.

        Args:
            part: `FITTED`, which is not attacked, or `JUDGED`.
            number: The number of the frame.
            format: `DETECTIONS_FORMAT`; cells of another one are done again.
        """
        if part not in self._parts:
            self._parts[part] = recordings_of(self._configuration, part)
        recordings = self._parts[part]
        recorded, system = recordings.frames[number], recordings.system
        frame = recorded.frame()
        seconds = dict.fromkeys(("attack", "lidar detector", "image detector"), 0.0)
        looks: list[tuple[Sensor, bool, SensorFrame]] = [
            (sensor, False, frame) for sensor in system.sensors
        ]
        truth = truth_of(frame, system.reference)
        known = () if truth is None else (DetectionRow(truth_setting(part), recorded.id, truth),)
        detections = list(known)
        if part == JUDGED:
            start = time.perf_counter()
            seed = (self._configuration.seed, number)
            attacked = tampered_frames(frame, system, part, seed)
            seconds["attack"] = time.perf_counter() - start
            looks += [(sensor, True, tampered.frame) for sensor, tampered in attacked.items()]
            detections.append(DetectionRow(PATCH, recorded.id, bogus_patch(attacked[LIDAR])))
        for sensor, state, source in looks:
            start = time.perf_counter()
            found = self._look(sensor, source)
            kind = "lidar detector" if sensor == LIDAR else "image detector"
            seconds[kind] += time.perf_counter() - start
            for camera in system.cameras if sensor == LIDAR else (int(sensor),):
                boxes = _seen_by(found, frame, camera) if sensor == LIDAR else found
                setting = seen_setting(part, sensor, state, camera)
                detections.append(DetectionRow(setting, recorded.id, boxes))
        rows = [
            Measurement(view_setting(part), recorded.id, name, value)
            for name, value in _views(frame, system).items()
        ]
        return CellResult(detections=detections, measurements=rows, seconds=seconds)

    def _look(self, sensor: Sensor, frame: SensorFrame) -> Boxes3D:
        if sensor == LIDAR:
            return self._lidar.detect(scan_alone(frame))
        return self._image.detect(frame, int(sensor))


def _views(frame: SensorFrame, system: SensorSystem) -> dict[str, float]:
    """`WIDTH`, and of two cameras the largest disparity."""
    cameras = [(i, k) for i, k in system.pairs() if system.sensors[i] != LIDAR]
    reach = {
        reach_name((i, k)): disparity_reach(
            frame.calibration, int(system.sensors[k]), int(system.sensors[i])
        )
        for i, k in cameras
    }
    return {WIDTH: float(frame.image(system.reference).shape[1]), **reach}


def _seen_by(boxes: Boxes3D, frame: SensorFrame, camera: int) -> Boxes3D:
    height, width = frame.image(camera).shape[:2]
    return boxes_seen_by(boxes, frame.calibration.projection(camera), (height, width))
