"""Writes studies/results/detectors.md: every figure of it comes from the JSON files beside it.

Run ``python -m studies.perception.page --results studies/results``, after the commands
that write these files (``python -m studies.detectors``).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from avsec_gym.errors import DataError
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.report.markdown_table import markdown_table, number
from avsec_gym.storage.json_files import read_json
from avsec_gym.storage.regular_files import is_file
from avsec_gym.storage.text_files import write_text
from studies.answer import answer
from studies.perception.classifier_accuracy import ClassifierAccuracy
from studies.perception.decoding_rules import DecodingRules, rules_of_decoding
from studies.perception.detection_errors import LEVEL
from studies.perception.detector_precision import AIMS, DetectorPrecision
from studies.perception.detector_scores import Interval
from studies.perception.disparity_accuracy import DisparityAccuracy
from studies.perception.page_classifiers import classifiers
from studies.perception.page_errors import examples, reasons
from studies.perception.page_frames import assets_of, held_out, world_make
from studies.perception.page_history import (
    every_disparity,
    every_scoring,
    real_then_and_now,
    trainings,
)
from studies.perception.page_networks import (
    DetectorTimes,
    RankedDetector,
    contested,
    disparity,
    parity,
    ranking,
    real,
    seconds,
)
from studies.perception.page_parts import by_assets, by_distance, by_occlusion
from studies.perception.page_seen_assets import seen_assets
from studies.perception.page_single_sensor import moderate, single_sensor
from studies.perception.page_training import training
from studies.perception.real_frames import DetectorsInRealFrames
from studies.perception.single_sensor_precision import SingleSensorPrecision
from studies.perception.training_curves import NetworkCurves
from studies.perception.training_history import Training, TrainingHistory

FILES = {
    "detectors": "detectors.json",
    "single": "single_sensor_detectors.json",
    "curves": "detector_training.json",
    "history": "training_history.json",
    "rules": "decoding_rules.json",
    "real": "real_frames.json",
    "disparity": "disparity.json",
    "classifiers": "classifiers.json",
    "seconds": "detector_benchmark.json",
    "ranking": "detector_ranking.json",
    "contested": "contested_ranking.json",
    "parity": "parity.json",
}
"""What the page shows; only the first must be there."""
Result = TypeVar("Result")

_ANEW = "Make it anew."
_METRICS = {"2d": "in the image", "bev": "from above", "3d": "in space", "aos": "orientation"}


@dataclass(frozen=True)
class DetectorResults:
    """What the page shows; parts that are None are left out."""

    detectors: DetectorPrecision
    single: SingleSensorPrecision | None = None
    curves: Mapping[str, NetworkCurves] | None = None
    history: TrainingHistory | None = None
    rules: DecodingRules | None = None
    real: DetectorsInRealFrames | None = None
    disparity: DisparityAccuracy | None = None
    classifiers: ClassifierAccuracy | None = None
    seconds: DetectorTimes | None = None
    ranking: Sequence[RankedDetector] | None = None
    contested: Sequence[RankedDetector] | None = None
    parity: Mapping[str, Mapping[str, float]] | None = None


def run(options: argparse.Namespace) -> dict[str, Any]:
    """Write the page; which files it was made of.

    Raises:
        DataError: There is no result of the detectors, or a file is none of its kind.
    """
    folder: Path = options.results
    text = page(read_results(folder))
    write_text(folder / "detectors.md", text, overwrite=True)
    return {
        "page": "detectors.md",
        "of": [file for file in FILES.values() if is_file(folder / file)],
    }


def read_results(folder: Path) -> DetectorResults:
    """The results in a folder, by the names of `FILES`.

    Raises:
        DataError: There is no result of the detectors, or a file is none of its kind.
    """

    def read(name: str, parse: Callable[[Any], Result]) -> Result | None:
        path = folder / FILES[name]
        if not is_file(path):
            return None
        try:
            return parse(read_json(path, remedy=_ANEW))
        except (KeyError, TypeError, AttributeError, ValueError) as error:
            raise DataError(
                f"This is no result of {name}, or one of an earlier version ({error!r}).",
                path=path,
                remedy=_ANEW,
            ) from error

    detectors = read("detectors", lambda found: row_of(DetectorPrecision, found))
    if detectors is None:
        raise DataError(
            "There is no result of the detectors.",
            path=folder / FILES["detectors"],
            remedy="python -m studies.perception.detector_precision writes it.",
        )
    return DetectorResults(
        detectors,
        single=read("single", lambda found: row_of(SingleSensorPrecision, found)),
        curves=read("curves", _curves),
        history=read("history", lambda found: row_of(TrainingHistory, found)),
        rules=read("rules", lambda found: row_of(DecodingRules, found)),
        real=read("real", lambda found: row_of(DetectorsInRealFrames, found)),
        disparity=read("disparity", lambda found: row_of(DisparityAccuracy, found)),
        classifiers=read("classifiers", lambda found: row_of(ClassifierAccuracy, found)),
        seconds=read("seconds", DetectorTimes.from_json),
        ranking=read("ranking", _ranked),
        contested=read("contested", _ranked),
        parity=read("parity", dict),
    )


def _ranked(found: Sequence[Mapping[str, Any]]) -> list[RankedDetector]:
    return [row_of(RankedDetector, row) for row in found]


def _curves(found: Mapping[str, Any]) -> dict[str, NetworkCurves]:
    return {name: NetworkCurves.from_json(curves) for name, curves in found.items()}


def page(results: DetectorResults) -> str:
    """The page as Markdown."""
    scores = results.detectors
    known = results.history.trainings if results.history else ()
    sections = [
        _head(scores, known),
        _musts(scores),
        _in_full(scores),
        by_distance(scores),
        by_occlusion(scores),
        by_assets(scores),
        reasons(scores),
        rules_of_decoding(results.rules) if results.rules else [],
        examples(scores),
        single_sensor(results.single, known) if results.single else [],
        training(scores.detectors, results.single, results.disparity, results.curves, known),
        trainings(results.history) if results.history else [],
        seen_assets(known),
        every_scoring(results.history.scorings) if results.history else [],
        real(results.real) if results.real else [],
        real_then_and_now(results.history.real) if results.history else [],
        disparity(results.disparity) if results.disparity else [],
        every_disparity(results.history.disparity) if results.history else [],
        classifiers(results.classifiers) if results.classifiers else [],
        seconds(results.seconds) if results.seconds else [],
        ranking(results.ranking) if results.ranking is not None else [],
        contested(results.contested) if results.contested is not None else [],
        parity(results.parity) if results.parity is not None else [],
    ]
    return "\n\n".join("\n".join(section) for section in sections if section) + "\n"


def _head(scores: DetectorPrecision, known: Sequence[Training]) -> list[str]:
    data, cars = scores.data, scores.data.cars
    cards = {name: figures.weights for name, figures in scores.detectors.items()}
    where, made = "labelled frames", []
    if data.suite is not None:
        where = (
            f"frames of the procedural world (suite `{data.suite}`, seed {data.seed},"
            f" {assets_of(data)}, sources {data.fingerprint})"
        )
        made = [f"{world_make(data)} --no-lidar --out HELD_OUT"]
    return [
        "# What the small detectors reach",
        "",
        f"On {data.frames} {where} with {data.objects} labelled objects, {cars.all} of"
        f" them cars; to be found are {cars.easy} (easy), {cars.moderate} (moderate),"
        f" {cars.hard} (hard). {held_out(data, cards, known)}"
        " Average precision of cars by KITTI's rules in percent, with 95 % bootstrap intervals over"
        f" frames ({scores.resamples} draws). Numbers in [detectors.json](detectors.json);"
        " everything on this page is made by `python -m studies.detectors`, this part by",
        "",
        "```",
        *made,
        "python -m studies.perception.detector_precision --kitti HELD_OUT"
        f" --detectors {' '.join(row.asked for row in scores.detectors.values())}",
        "```",
    ]


def _musts(scores: DetectorPrecision) -> list[str]:
    rows, remarks = [], []
    reached: dict[str, float] = {}
    for name, figures in scores.detectors.items():
        strict, loose = (figures.scores.average_precision[iou]["3d"] for iou in ("0.7", "0.5"))
        value, loosely = (each.ap11[LEVEL] or 0.0 for each in (strict, loose))
        reached[name] = value
        aim = AIMS.get(name)
        rows.append(
            [
                f"`{name}`",
                moderate(strict.ap11, strict.ap11_interval),
                number(aim and aim.must, 0),
                number(aim and aim.goal, 0),
                moderate(strict.ap40, strict.ap40_interval),
                moderate(loose.ap11, loose.ap11_interval),
                number(aim and aim.must_loosely, 0),
                moderate(loose.ap40, loose.ap40_interval),
                number(figures.thesis and figures.thesis[LEVEL], 2),
            ]
        )
        if aim is not None:
            met = value >= aim.must and loosely >= aim.must_loosely
            # An interval that contains what must be reached leaves open whether it is.
            surely = all(
                score.ap11_interval and (score.ap11_interval[LEVEL][0] or 0.0) >= must
                for score, must in ((strict, aim.must), (loose, aim.must_loosely))
            )
            goal = (
                f"misses its goal by {aim.goal - value:.1f}"
                if value < aim.goal
                else f"passes its goal by {value - aim.goal:.1f}"
            )
            close = ", by less than its intervals are wide," if met and not surely else ""
            remarks.append(
                f"`{name}` {'meets' if met else 'misses'} what it must{close} and {goal}."
            )
    order = sorted(reached, key=lambda name: -reached[name])
    return [
        "## Against what they must",
        "",
        "Cars in space, moderate, with what was asked of each network before it was trained. Beside"
        " it stand the thesis' figures for the full networks on real KITTI: other networks, other"
        " data.",
        "",
        *markdown_table(
            ["detector", "AP11, IoU 0.7", "must", "goal", "AP40, IoU 0.7", "AP11, IoU 0.5",
             "must", "AP40, IoU 0.5", "thesis, AP11, IoU 0.7"],
            rows,
        ),
        "",
        " ".join([*remarks, "In order of precision: " + ", ".join(order) + "."]),
    ]  # fmt: skip


def _in_full(scores: DetectorPrecision) -> list[str]:
    lines = ["## In full", "", "Easy / moderate / hard; the interval is that of moderate."]
    for name, figures in scores.detectors.items():
        rows = []
        for metric, title in _METRICS.items():
            for iou, values in figures.scores.average_precision.items():
                if iou == "0.5" and metric not in ("bev", "3d"):
                    continue  # In the image both sets of thresholds ask for 0.7.
                every = values[metric]
                cells = [
                    _levels(every.ap11, every.ap11_interval),
                    _levels(every.ap40, every.ap40_interval),
                ]
                rows.append([title, iou, *cells])
        lines += ["", f"**`{name}`**", ""]
        lines += markdown_table(["metric", "IoU", "AP11", "AP40"], rows)
        lines += ["", f"![Precision over recall of {name}](images/{name}_precision.png)"]
    return lines


def _levels(values: Sequence[float | None], bounds: Sequence[Interval] | None) -> str:
    text = " / ".join(number(value, 1) for value in values)
    if not bounds:
        return text
    low, high = (number(bound, 1) for bound in bounds[LEVEL])
    return f"{text} ({low} to {high})"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--results", type=Path, default=Path("studies/results"))
    parser.add_argument("--json", type=Path, help="file for a summary; default: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
