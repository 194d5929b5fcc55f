"""What each rule gives by which a network's output becomes boxes: one rule is undone at a time.

Run ``python -m studies.perception.decoding_rules --kitti DIR --json FILE`` on the frames that the
rules were chosen on (suite ``mixed``, seed 101, training assets): nothing here is judged.  Weights
and all other rules stay as shipped.  What was decided in a training (planes weighted on cars, finer
height cells, headings modulo half a turn) cannot be undone without another one.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.console import progress
from avsec_gym.metrics.average_precision import METRICS, average_precision
from avsec_gym.metrics.cluster_bootstrap import Sampled
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.report.markdown_table import interval, markdown_table
from studies.answer import answer
from studies.perception.detection_errors import CATEGORY, LEVEL
from studies.perception.detector_scores import IOUS
from studies.perception.kept_detections import (
    LabelledData,
    add_options,
    described,
    labelled_frames,
)

_NEEDED = ("label_2", "calib", "image_2", "image_3")
_MAKE = "avsec world make --suite mixed --frames 100 --seed 101 --assets train --no-lidar --out DIR"
_SHIPPED = "as shipped"
RULES: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    "dsgn": {
        "no votes": {"rule": {"voting_overlap": None}},
        "votes from an overlap of 0.3 on": {"rule": {"voting_overlap": 0.3}},
        "boxes may overlap by 0.6, as published": {"rule": {"most_overlap": 0.6}},
        "score of the class alone, as published": {"rule": {"fit_share": 0.0}},
        "score of the fit alone": {"rule": {"fit_share": 1.0}},
    },
    "stereo_rcnn": {
        "score of the class alone, as published": {"rule": {"fit_share": 0.0}},
        "depths in whole steps, as published": {"alignment": {"parabola": False}},
        "faces on the box, as published": {
            "alignment": {"side_inset": 0.0, "front_inset": 0.0, "rear_inset": 0.0}
        },
        "differences of colour in full, as published": {"alignment": {"most_difference": None}},
    },
}
"""The rules that are undone, by detector and words: an argument of the detector, and its change."""
_MADE = {"dsgn": DsgnDetector, "stereo_rcnn": StereoRcnnDetector}


@dataclass(frozen=True)
class RulePrecision:
    """A detector with a rule undone; average precision of cars in space, moderate, AP11, percent.

    Args:
        detector: The detector's name.
        rule: What was done instead.
        precision: The precision, by the names of `IOUS`.
        difference: The precision less that as shipped, paired frame by frame.
    """

    detector: str
    rule: str
    precision: Mapping[str, Estimate]
    difference: Mapping[str, Estimate]


@dataclass(frozen=True)
class DecodingRules:
    """The result."""

    data: LabelledData
    resamples: int
    rows: Sequence[RulePrecision]


def run(options: argparse.Namespace) -> DecodingRules:
    """Detect by each set of rules, and score.

    Raises:
        ConfigurationError: An option makes no sense.
        DataError: The folder has no frames, or a file is broken.
    """
    data, ids, truth = labelled_frames(options, _NEEDED, _MAKE)
    made = {
        (name, words): _with(name, change)
        for name, rules in RULES.items()
        for words, change in {_SHIPPED: {}, **rules}.items()
    }
    found: dict[tuple[str, str], list[Boxes3D]] = {key: [] for key in made}
    with progress("detecting") as shown:
        for number, id in enumerate(ids, start=1):
            frame = data.frame(id)
            for key, detector in made.items():
                found[key].append(detector.detect(frame))
            shown(number, len(ids))
    scored = {key: _scored(truth, boxes, options) for key, boxes in found.items()}
    return DecodingRules(
        described(data, truth),
        options.resamples,
        [
            RulePrecision(
                name,
                words,
                {iou: each.estimate for iou, each in scores.items()},
                {
                    iou: (each - scored[name, _SHIPPED][iou]).estimate
                    for iou, each in scores.items()
                },
            )
            for (name, words), scores in scored.items()
        ],
    )


def rules_of_decoding(result: DecodingRules) -> list[str]:
    """The section of detectors.md."""
    rows = [
        [
            f"`{row.detector}`",
            row.rule,
            *(
                interval(each.value, each.interval) if each is not None else ""
                for iou in IOUS
                for each in (
                    row.precision[iou],
                    None if row.rule == _SHIPPED else row.difference[iou],
                )
            ),
        ]
        for row in result.rows
    ]
    columns = [title for iou in IOUS for title in (f"AP11, IoU {iou}", "difference")]
    data = result.data
    return [
        "## What each rule of decoding gives",
        "",
        f"AP11 of cars in space, moderate, on {data.frames} frames (suite `{data.suite}`, seed"
        f" {data.seed}, {data.assets} assets), which the rules and the calibration were chosen on:"
        " one rule is undone, the weights and all other rules stay. Differences to the first line"
        " of a detector are paired, frame by frame.",
        "",
        *markdown_table(["detector", "rule", *columns], rows),
    ]


def _with(name: str, changes: Mapping[str, Mapping[str, Any]]) -> Detector:
    shipped = _MADE[name]("small", weights="shipped")
    arguments = {
        what: replace(getattr(shipped, what), **change) for what, change in changes.items()
    }
    return _MADE[name]("small", weights="shipped", **arguments) if arguments else shipped


def _scored(
    truth: Sequence[Boxes3D], found: Sequence[Boxes3D], options: argparse.Namespace
) -> dict[str, Sampled]:
    place = (0, METRICS.index("3d"), LEVEL)
    scores = {}
    for name, least in IOUS.items():
        result = average_precision(
            truth, found, classes=(CATEGORY,), min_iou=least,
            resamples=options.resamples, seed=options.seed,
        )  # fmt: skip
        samples = np.zeros(0) if result.drawn is None else result.drawn[place][:, 0]
        scores[name] = Sampled(float(result.ap11[place]), samples)
    return scores


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    add_options(parser)
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
