"""`avsec weights calibrate`: makes a detector's scores probabilities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import tyro

from avsec_gym import console
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.registry import Kind, make

if TYPE_CHECKING:
    from avsec_gym.kitti.dataset import KittiObject
    from avsec_gym.perception.detectors.score_calibration import ScoreCalibration
    from avsec_gym.perception.weights.model_card import ModelCard

_PAIR, _SCAN, _IMAGE = ("image_2", "image_3"), ("velodyne",), ("image_2",)
_LOOKS_AT = {
    "dsgn": (Kind.DETECTOR, _PAIR),
    "stereo_rcnn": (Kind.DETECTOR, _PAIR),
    "pixor": (Kind.DETECTOR, _SCAN),
    "pointrcnn": (Kind.DETECTOR, _SCAN),
    "faster_rcnn": (Kind.IMAGE_DETECTOR, _IMAGE),
    "yolo": (Kind.IMAGE_DETECTOR, _IMAGE),
}
"""What is looked at, by the networks whose scores can be calibrated."""


@dataclass(frozen=True)
class WeightsCalibrate:
    """Make scores probabilities: of boxes with a score of 0.3, three in ten will be cars.

    What is found is held against labels (moderate cars, IoU 0.5 from above, or in the image of what
    a detector of images finds); the function that fits is kept in the weights' card, and the
    detector scores by it from then on. Boxes keep their order, and with it average precision, but
    Stereo R-CNN's: its scores also count how well both images agree on a box, unless --no-evidence.
    The card's precision becomes that on these frames.
    """

    file: Annotated[Path, tyro.conf.Positional]
    """Weights of a detector, as `avsec train` writes them, with their card."""
    kitti: Path
    """Frames in KITTI's object layout that the network has not learned from."""
    split: str | None = None
    """The frames of ImageSets/SPLIT.txt, such as val.  Default: all that have labels."""
    limit: int | None = None
    """Only the first frames."""
    evidence: bool = field(
        default=True,
        metadata={"help": "Do not count the agreement of both images, of a detector that does."},
    )
    """Whether the agreement of both images counts, of a detector that looks at it."""
    json: bool = False
    """Print the line and how scores were before and after as JSON."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.kitti.dataset import KittiObject
        from avsec_gym.metrics.working_point import FROM_ABOVE, IN_IMAGE, boxes_right_and_wrong
        from avsec_gym.perception.detectors.score_calibration import (
            NAME,
            ScoreCalibration,
            fit_score_calibration,
        )
        from avsec_gym.perception.training.labelled_frames import DataFrames
        from avsec_gym.perception.training.training_data import described
        from avsec_gym.perception.weights.store import read_card, write_card
        from avsec_gym.storage.regular_files import MAX_FILE_BYTES, check_regular

        check_regular(self.file, most=MAX_FILE_BYTES)
        # The detector as it was trained, without the calibration that it may have.
        card = read_card(self.file)
        if card is None or card.network not in _LOOKS_AT:
            raise DataError(
                "These are no weights of a detector with a card.",
                path=self.file,
                remedy=f"Name those that `avsec train` wrote of {', '.join(_LOOKS_AT)}.",
            )
        kind, looks_at = _LOOKS_AT[card.network]
        detector: Any = make(
            kind, {"name": card.network, "weights": str(self.file), **_configuration(card)}
        )
        detector.calibration = ScoreCalibration()
        data = KittiObject(self.kitti)
        ids = data.ids(self.split, having=(*looks_at, "label_2"))[: self.limit]
        if not ids:
            raise DataError(
                f"There is no labelled frame with {' and '.join(looks_at)}.", path=self.kitti
            )
        # Detections of all frames, and which of them are cars.
        found, evidence = _evidenced_in_all(detector, data, ids)
        labels = [data.labels(id, keep_dont_care=True) for id in ids]
        seen = IN_IMAGE if kind == Kind.IMAGE_DETECTOR else FROM_ABOVE
        rows, right, wrong = boxes_right_and_wrong(labels, found, seen)
        scores = np.concatenate([boxes.score for boxes in found])[rows]
        beside = np.concatenate(evidence)[rows] if self.evidence else None
        # The logistic line through them stands in the card from now on.
        line = fit_score_calibration(scores, right, wrong, beside)
        card.beside[NAME] = [line.slope, line.offset, *line.evidence]
        known = evidence if self.evidence else [None for _ in found]
        scored = [
            replace(boxes, score=line(boxes.score, beside))
            for boxes, beside in zip(found, known, strict=True)
        ]
        measured = replace(
            card,
            metrics=_precision_anew(card.metrics, labels, scored, kind),
            data={**card.data, "calibration": [described(DataFrames(data, tuple(ids)))]},
        )
        write_card(self.file, measured)
        self._report(line, frames=len(ids), right=int(right.sum()), wrong=int(wrong.sum()))
        return console.DONE

    def _report(self, line: ScoreCalibration, *, frames: int, right: int, wrong: int) -> None:
        """Print the fitted line, and what it was fitted on."""
        summary = {
            "slope": line.slope,
            "offset": line.offset,
            "evidence": line.evidence,
            "frames": frames,
            "right": right,
            "wrong": wrong,
        }
        if self.json:
            console.print_json("weights.calibrate", summary)
        else:
            console.say(
                f"{self.file}: by {right} cars and {wrong} false alarms in"
                f" {frames} frames, log-odds x {line.slope:.3f} {line.offset:+.3f}"
                + "".join(f" {weight:+.3f}" for weight in line.evidence)
            )


def _configuration(card: ModelCard) -> dict[str, str]:
    """The preset of weights, where several may be theirs."""
    if card.network != "dsgn":
        return {}
    from avsec_gym.perception.detectors.dsgn.editions import preset_name

    return {"configuration": preset_name(card)}


def _precision_anew(
    metrics: Mapping[str, float], labels: Sequence[Boxes3D], found: Sequence[Boxes3D], kind: Kind
) -> dict[str, float]:
    """The average precisions of a card, percent, as these detections have them."""
    from avsec_gym.metrics.average_precision import LOW_IOU
    from avsec_gym.perception.training.precision import half_in_images, precision

    names = [name.partition("_") for name in metrics if "_ap" in name]
    measures: dict[str, list[str]] = {}
    for category, _, measure in names:
        measures.setdefault(category, []).append(measure)
    result: dict[str, float] = {}
    for category, wanted in measures.items():
        easier = half_in_images(category) if kind == Kind.IMAGE_DETECTOR else LOW_IOU
        result |= precision(labels, found, category, wanted, easier)
    return result


def _evidenced_in_all(
    detector: Any, data: KittiObject, ids: Sequence[str]
) -> tuple[list[Boxes3D], list[Floats]]:
    """`_evidenced` of each frame, with progress on the console."""
    found, evidence = [], []
    with console.progress("detecting") as shown:
        for done, id in enumerate(ids, start=1):
            boxes, known = _evidenced(detector, data.frame(id))
            found.append(boxes)
            evidence.append(known)
            shown(done, len(ids))
    return found, evidence


def _evidenced(detector: Any, frame: SensorFrame) -> tuple[Boxes3D, Floats]:
    """What is found in a frame, and what else than its score speaks for each box, (N, K)."""
    if not hasattr(detector, "evidenced"):
        boxes: Boxes3D = detector.detect(frame)
        return boxes, np.zeros((len(boxes), 0))
    from avsec_gym.perception.stereo_batch import batch_of_frames

    (found,) = detector.evidenced(batch_of_frames([frame]))
    return found.boxes, found.evidence
