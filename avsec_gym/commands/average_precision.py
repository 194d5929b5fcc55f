"""`avsec ap`: a detector's result files scored as the KITTI object benchmark does."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from avsec_gym import console
from avsec_gym.argument_checks import resample_number, seed_number, whole_number
from avsec_gym.errors import DataError
from avsec_gym.json_schemas import with_schema
from avsec_gym.storage.regular_files import is_there

if TYPE_CHECKING:
    from avsec_gym.boxes import Boxes3D
    from avsec_gym.metrics.average_precision import AveragePrecision
    from avsec_gym.metrics.safety_weighted_recall import SafetyWeightedRecall

WEIGHTED = "Car"
"""The class whose recall is weighted: cars are obstacles, pedestrians and cyclists are not."""
_REMARKS = 10
"""So many broken files are reported one by one."""


@dataclass(frozen=True)
class ScoreDetections:
    """Average precision of KITTI result files: image, bird's eye, 3D, orientation; in percent."""

    kitti: Path
    """A folder in KITTI's object layout (the one that holds `training`, or label_2 itself)."""
    detections: Path
    """A detector's KITTI result folder: files such as 000107.txt with 16 columns."""
    split: str | None = None
    """Frames of ImageSets/SPLIT.txt, such as val, or of a .txt file that lists frame ids.  Each of
    them counts, with or without a result file.  Default: every labelled frame."""
    limit: int | None = None
    """Only the first frames."""
    iou: Literal["standard", "low"] = "standard"
    """How much boxes must overlap: cars 0.7, others 0.5; low: in bird's eye and 3D cars 0.5, others
    0.25."""
    resamples: int = 0
    """Frames are drawn anew so many times for 95 % bootstrap intervals, such as 1000; 0: none.
    Those of one drive are drawn together where the devkit's mapping is in the folder."""
    seed: int = 0
    """Seed of these draws."""
    safety_weighted: bool = False
    """Whether the recall of cars is shown as well in which each counts by the time until a car that
    goes left, straight on and right would be near it; a label is found where a detection that may
    be planned on (score of 0.3 or more; 0, if scores have no bounds) overlaps it from above.  It
    takes a millisecond a frame."""
    figure: Path | None = None
    """Where to write a PNG of precision over recall."""
    out: Path | None = None
    """Where to write a JSON file with everything: figures, thresholds, number of labels, curves,
    frames left out, settings."""
    json: bool = False
    """Instead of a table, {"schema": ..., class: {"2d"|"bev"|"3d"|"aos": {"ap11": [easy, moderate,
    hard], "ap40": [...]}, "labels": [...], "ceiling": {"ap11": [...], "ap40": [...]}}}: labels that
    count, and what perfect detections of them reach; --resamples adds ap11_interval and
    ap40_interval, --safety-weighted "safety_weighted_recall": {"recall": ..., "by_intention": ...,
    ...} of Car."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.kitti import KittiObject
        from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU, average_precision
        from avsec_gym.metrics.average_precision_curves import FEWEST_LABELS

        # What can be refused before anything is read.
        if self.limit is not None:
            whole_number("--limit", self.limit, 1)
        resample_number("--resamples", self.resamples)
        seed_number("--seed", self.seed)
        for path in (self.figure, self.out):
            if path is not None and is_there(path):
                raise DataError(
                    "this exists already.",
                    path=path,
                    remedy="Name another file; nothing is overwritten.",
                )
        # Labels and detections, and their precision.
        frames = _ScoredFrames.read(self.kitti, self.split, self.limit, self.detections)
        frames.tell()
        drives = KittiObject(self.kitti).drives_of(list(frames.truth)) if self.resamples else None
        result = average_precision(
            list(frames.truth.values()),
            [frames.detections[id] for id in frames.truth],
            min_iou=STANDARD_IOU if self.iou == "standard" else LOW_IOU,
            resamples=self.resamples,
            seed=self.seed,
            together=drives,
        )
        weighted = self._weighted(frames) if self.safety_weighted else None
        # Files, remarks and table.
        if drives is not None:
            console.say(f"avsec: intervals draw whole drives: the frames are of {len(set(drives))}")
        if self.out is not None:
            from avsec_gym.storage.text_files import write_text

            report = _report(result, frames, weighted) | {"settings": self._settings()}
            report = with_schema("ap.report", report)
            write_text(self.out, json.dumps(report, indent=1, allow_nan=False) + "\n")
        if self.figure is not None:
            from avsec_gym.drawing.precision_recall import draw_precision_recall
            from avsec_gym.drawing.scenario_picture import save_picture

            save_picture(draw_precision_recall(result, title=self.detections.name), self.figure)
        few = _few(result)
        if few:
            console.say(
                f"avsec: fewer than {FEWEST_LABELS} labels count ({few}): even perfect detections"
                " stay below 100 %, see the ceiling; and single labels decide"
            )
        if self.json:
            console.print_json("ap", _with_ceilings(result, weighted))
        else:
            _show(result, f"{self.detections}: {len(frames.truth)} frames")
            if weighted is not None:
                _show_weighted(weighted)
        in_part = frames.broken or frames.missing
        return console.DONE_IN_PART if in_part else console.DONE

    def _weighted(self, frames: _ScoredFrames) -> SafetyWeightedRecall:
        """Of the cars, with what would be planned on."""
        import numpy as np

        from avsec_gym.kitti.detections import default_score_threshold
        from avsec_gym.metrics.safety_weighted_recall import safety_weighted_recall

        seen = [frames.detections[id] for id in frames.truth]
        return safety_weighted_recall(
            list(frames.truth.values()),
            seen,
            threshold=default_score_threshold(np.concatenate([boxes.score for boxes in seen])),
            category=WEIGHTED,
            resamples=self.resamples,
            seed=self.seed,
        )

    def _settings(self) -> dict[str, Any]:
        from avsec_gym import __version__

        asked = {
            name: str(value) if isinstance(value, Path) else value
            for name, value in asdict(self).items()
            if name not in ("json", "out", "figure")
        }
        return asked | {"version": __version__}


@dataclass(frozen=True)
class _ScoredFrames:
    """What is compared, and what could not be."""

    folder: Path
    truth: dict[str, Boxes3D]
    detections: dict[str, Boxes3D]
    missing: list[str]
    broken: dict[str, DataError]

    @classmethod
    def read(
        cls, kitti: Path, split: str | None, limit: int | None, detections: Path
    ) -> _ScoredFrames:
        """All frames asked for; those with a broken file are left out.

        Raises:
            DataError: A folder or split is missing, or no frame is left.
        """
        from avsec_gym.commands.named_scenes import split_ids
        from avsec_gym.kitti import DetectionFolder, KittiObject

        data = KittiObject(kitti)
        ids = split_ids(data, split)[:limit]
        if not ids:
            raise DataError(
                "there is no frame to score.", path=split or kitti, remedy="Name another split."
            )
        broken: dict[str, DataError] = {}
        found, missing = DetectionFolder(detections).read(ids, broken, image_only=True)
        truth = {}
        for id in ids:
            try:
                truth[id] = data.labels(id, keep_dont_care=True)
            except DataError as error:
                broken.setdefault(id, error)
        truth = {id: boxes for id, boxes in truth.items() if id not in broken}
        if not truth:
            raise next(iter(broken.values()))
        return cls(detections, truth, found, missing, broken)

    def tell(self) -> None:
        """Remark on what is not as it should be."""
        import numpy as np

        from avsec_gym.image_only import is_image_only

        for error in list(self.broken.values())[:_REMARKS]:
            console.say(f"avsec: left out: {error}")
        if len(self.broken) > _REMARKS:
            console.say(f"avsec: left out: {len(self.broken) - _REMARKS} more frames")
        if self.missing:
            names = ", ".join(self.missing[:5]) + (" ..." if len(self.missing) > 5 else "")
            console.say(
                f"avsec: {self.folder}: {len(self.missing)} of"
                f" {len(self.truth) + len(self.broken)} frames have no file and count as without"
                f" detections: {names}"
            )
        heights = [
            boxes.box2d[:, 3] - boxes.box2d[:, 1]
            for boxes in self.detections.values()
            if boxes.box2d is not None
        ]
        lost = sum(int(is_image_only(boxes).sum()) for boxes in self.detections.values())
        if lost:
            count = sum(map(len, self.detections.values()))
            console.say(
                f"avsec: {self.folder}: no detection has a 3D box; only the image is scored"
                if lost == count
                else f"avsec: {self.folder}: {lost} of {count} detections have no 3D box; they are"
                " scored in the image, and match nothing in bird's eye and 3D"
            )
        flat = int((np.concatenate(heights) == 0).sum()) if heights else 0
        if flat:
            console.say(
                f"avsec: {self.folder}: {flat} detections have a 2D box without height; KITTI"
                " ignores them in every metric. Write the projection of the 3D box."
            )


def _with_ceilings(
    result: AveragePrecision, weighted: SafetyWeightedRecall | None
) -> dict[str, dict[str, Any]]:
    """The figures, and of each class how many labels count and what perfect detections reach.

    Args:
        result: The average precision.
        weighted: The weighted recall of cars; None: it was not asked for.
    """
    figures: dict[str, dict[str, Any]] = {**result.to_json()}
    for c, category in enumerate(result.classes):
        best = result.ceiling[c].round(4).T.tolist()
        figures[category] = {
            **figures[category],
            "labels": result.labels[c].tolist(),
            "ceiling": dict(zip(("ap11", "ap40"), best, strict=True)),
        }
    if weighted is not None:
        figures[WEIGHTED]["safety_weighted_recall"] = weighted.to_json()
    return figures


def _few(result: AveragePrecision) -> str:
    """Where there are labels, but too few: ``Car: easy 5, moderate 18; Cyclist: ...``."""
    from avsec_gym.metrics.average_precision_curves import FEWEST_LABELS
    from avsec_gym.metrics.average_precision_frames import LEVELS

    found = []
    for category, counts in zip(result.classes, result.labels.tolist(), strict=True):
        few = [
            f"{level} {count}"
            for level, count in zip(LEVELS, counts, strict=True)
            if 0 < count < FEWEST_LABELS
        ]
        if few:
            found.append(f"{category}: {', '.join(few)}")
    return "; ".join(found)


def _report(
    result: AveragePrecision, frames: _ScoredFrames, weighted: SafetyWeightedRecall | None
) -> dict[str, Any]:
    """The whole result, for --out."""
    from avsec_gym.metrics.average_precision import METRICS
    from avsec_gym.metrics.average_precision_frames import LEVELS

    per_class: dict[str, dict[str, Any]] = {"min_iou": {}, "labels": {}, "precision": {}}
    for c, category in enumerate(result.classes):
        per_class["min_iou"][category] = dict(zip(METRICS, result.min_iou[c].tolist(), strict=True))
        per_class["labels"][category] = dict(zip(LEVELS, result.labels[c].tolist(), strict=True))
        per_class["precision"][category] = {
            metric: {
                level: [None if value != value else round(value, 6) for value in curve]
                for level, curve in zip(LEVELS, result.precision[c, m].tolist(), strict=True)
            }
            for m, metric in enumerate(METRICS)
        }
    return {
        "average_precision": _with_ceilings(result, weighted),
        **per_class,
        "frames": len(frames.truth),
        "frames_without_detections": frames.missing,
        "left_out": [str(error) for error in frames.broken.values()],
    }


def _show(result: AveragePrecision, title: str) -> None:
    import numpy as np

    from avsec_gym.metrics.average_precision import METRICS
    from avsec_gym.metrics.average_precision_frames import LEVELS

    rows = []
    for c, category in enumerate(result.classes):
        for m, metric in enumerate(METRICS):
            if metric in ("bev", "3d") and np.isnan(result.precision[c, m]).all():
                continue  # Known in the image only.
            for points, values in enumerate((result.ap11, result.ap40)):
                first = [category, metric, f"{result.min_iou[c, m]:g}"] if not points else [""] * 3
                cells = []
                for level, value in enumerate(values[c, m]):
                    known = value == value and result.labels[c, level] > 0
                    interval = None
                    if result.interval is not None:
                        interval = (result.interval[c, m, level, points] / 100).tolist()
                    cells.append(console.percent(value / 100 if known else None, interval))
                rows.append([*first, ("AP11", "AP40")[points], *cells])
        rows.append([category, "labels that count", "", "", *map(str, result.labels[c].tolist())])
        for points, best in enumerate(result.ceiling[c].T.tolist()):
            cells = [
                console.percent(value / 100 if count else None)
                for value, count in zip(best, result.labels[c].tolist(), strict=True)
            ]
            first = ["", "ceiling" if not points else "", ""]
            rows.append([*first, ("AP11", "AP40")[points], *cells])
    intervals = "" if result.interval is None else " and 95 % bootstrap intervals"
    columns = ["class", "metric", "IoU >", "recall points", *LEVELS]
    console.print_table(f"{title}, average precision in %{intervals}", columns, rows)


def _show_weighted(weighted: SafetyWeightedRecall) -> None:
    bounds = weighted.recall.interval
    cells = [
        console.percent(weighted.recall.value, None if bounds is None else [*bounds]),
        *(console.percent(share) for share in weighted.by_intention.values()),
        f"{weighted.threshold:g}",
    ]
    columns = ["class", "all", *weighted.by_intention, "score from"]
    title = "safety-weighted recall: cars found, each weighed by the time to contact, in %"
    console.print_table(title, columns, [[WEIGHTED, *cells]])
