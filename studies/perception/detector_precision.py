"""How precise detectors are on held-out frames, with intervals, and why precision is lost.

Run ``python -m studies.perception.detector_precision --kitti DIR --detectors dsgn
stereo_rcnn --json FILE --figures DIR``. A detector is a name, ``name:preset``, or ``name=FILE``
with weights of one's own. ``--other-part DIR`` has scenes of the other part of the assets, such as
those that networks learn from: the precision on both is compared. Frames of the procedural world
that are not of judging assets are refused, unless ``--any-assets`` is given. A run that was stopped
goes on: what was detected is kept in ``--out``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.json_rows import FLAT, OPTIONAL
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.perception.weights.given import shipped_weights
from studies.answer import answer
from studies.perception.asset_parts import PartsPrecision, SeenScenes, parts_precision
from studies.perception.detector_figures import Example, draw_examples, draw_precision
from studies.perception.detector_scores import IOUS, DetectorScores, detector_scores
from studies.perception.kept_detections import (
    FrameTime,
    LabelledData,
    add_options,
    check_judging_assets,
    described,
    detected,
    labelled_frames,
    seconds_a_frame,
)
from studies.perception.weights_facts import WeightsFacts, weights_facts


class Aim(NamedTuple):
    """The AP11 of cars in space, moderate, that a network is to reach here."""

    must: float
    """The least, at IoU 0.7."""
    goal: float
    """The aim, at IoU 0.7."""
    must_loosely: float
    """The least, at IoU 0.5."""


AIMS = {
    "dsgn": Aim(32.0, 45.0, 65.0),
    "dsgn_medium": Aim(42.0, 53.0, 72.0),
    "stereo_rcnn": Aim(40.0, 50.0, 72.0),
}
"""Set before the trainings on the world's second edition."""
_DSGN = (70.94, 52.98, 47.29)
THESIS = {"dsgn": _DSGN, "dsgn_medium": _DSGN, "stereo_rcnn": (56.47, 38.20, 32.66)}
"""The same of the full networks on real KITTI, easy, moderate and hard (section 5.4)."""

NEEDED = ("label_2", "calib", "image_2", "image_3")
"""Folders in which a frame has a file."""
_MAKE = "avsec world make --suite mixed --frames 400 --assets judge --no-lidar --out DIR"


@dataclass(frozen=True)
class ScoredDetector:
    """A detector, its scores, and what they are held against."""

    asked: str
    """What is asked, as the command line names it."""
    weights: WeightsFacts | None
    thesis: tuple[float, float, float] | None
    """See `THESIS`."""
    scores: DetectorScores = field(metadata=FLAT)
    seconds: FrameTime
    parts: Mapping[str, PartsPrecision] | None = field(default=None, metadata=OPTIONAL)
    """Precision on both parts of the assets, by `IOUS`; None where no other part was given."""


@dataclass(frozen=True)
class DetectorPrecision:
    """The result."""

    data: LabelledData
    resamples: int
    detectors: Mapping[str, ScoredDetector]
    examples: Sequence[Example] | None
    other_part: LabelledData | None = field(default=None, metadata=OPTIONAL)
    """Scenes of the other part of the assets; None: none were given."""


def run(options: argparse.Namespace) -> DetectorPrecision:
    """Detect, score, draw.

    Raises:
        ConfigurationError: A detector is unknown, an option makes no sense, the frames are not of
            judging assets, or the other part of the assets is the same.
        DataError: The folder has no frames, a file is broken, or there are no weights.
    """
    judged = _frames(options, options.kitti)
    check_judging_assets(judged.described, options)
    other = None if options.other_part is None else _other_part(options, judged)
    data, ids, truth = judged.data, judged.ids, judged.truth
    found: dict[str, list[Boxes3D]] = {}
    result: dict[str, ScoredDetector] = {}
    for text in options.detectors:
        asked = named(text)
        name = label_of(asked)
        weights = _weights(asked)
        found[name] = detected(asked, weights, data, ids, options.out, options.workers)
        parts = None
        if other is not None:
            there = detected(asked, weights, other.data, other.ids, options.out, options.workers)
            scenes = judged.seen(found[name]), other.seen(there)
            parts = {
                iou: parts_precision(*scenes, least, options.resamples, options.seed)
                for iou, least in IOUS.items()
            }
        result[name] = ScoredDetector(
            asked=text,
            weights=weights_facts(weights),
            thesis=THESIS.get(name),
            scores=detector_scores(truth, found[name], options.resamples, options.seed),
            seconds=seconds_a_frame(asked, data, ids[: options.timed]),
            parts=parts,
        )
    examples = None
    if options.figures is not None:
        draw_precision(truth, found, options.figures)
        points = {name: figures.scores.working_point for name, figures in result.items()}
        examples = draw_examples(data, ids, truth, found, points, options.figures)
    other_part = None if other is None else other.described
    return DetectorPrecision(judged.described, options.resamples, result, examples, other_part)


@dataclass(frozen=True, eq=False)
class _PartFrames:
    """Labelled frames of one part of the assets."""

    data: KittiObject
    ids: list[str]
    truth: list[Boxes3D]
    described: LabelledData

    def seen(self, found: Sequence[Boxes3D]) -> SeenScenes:
        return SeenScenes(self.described, self.truth, found)


def _frames(options: argparse.Namespace, root: Path) -> _PartFrames:
    there = argparse.Namespace(**{**vars(options), "kitti": root})
    data, ids, truth = labelled_frames(there, NEEDED, _MAKE)
    return _PartFrames(data, ids, truth, described(data, truth))


def _other_part(options: argparse.Namespace, judged: _PartFrames) -> _PartFrames:
    """The frames to compare with; ConfigurationError if they are of the same part."""
    other = _frames(options, options.other_part)
    if other.described.assets == judged.described.assets:
        raise ConfigurationError(
            f"--kitti and --other-part are both of the assets {judged.described.assets or 'all'!r}:"
            " give frames of `avsec world make --assets judge` and of `--assets train`"
        )
    return other


def named(text: str) -> dict[str, str]:
    """What the registry takes, of ``name`` or ``name=FILE``.

    Example:
        >>> named("dsgn=my.safetensors")
        {'name': 'dsgn', 'weights': 'my.safetensors'}
        >>> named("dsgn:medium")
        {'name': 'dsgn', 'configuration': 'medium'}
    """
    detector, _, weights = text.partition("=")
    name, _, preset = detector.partition(":")
    given = {"configuration": preset, "weights": weights}
    return {"name": name} | {what: value for what, value in given.items() if value}


def label_of(asked: Mapping[str, str]) -> str:
    """The name of a detector on the page and of its pictures, such as dsgn_medium."""
    preset = asked.get("configuration", "small")
    return asked["name"] if preset == "small" else f"{asked['name']}_{preset}"


def _weights(asked: Mapping[str, str]) -> Path | None:
    """The file of weights that a detector takes; None for one without."""
    if "weights" in asked:
        return Path(asked["weights"])
    preset = asked.get("configuration", "small")
    return shipped_weights(f"{asked['name']}_{preset}") if asked["name"] in AIMS else None


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    add_options(parser)
    parser.add_argument("--detectors", nargs="+", default=["dsgn", "dsgn:medium", "stereo_rcnn"])
    parser.add_argument("--other-part", type=Path, help="scenes of the other part of the assets")
    parser.add_argument("--figures", type=Path, help="folder for pictures")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
