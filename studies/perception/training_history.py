"""How the shipped weights came about: their trainings, and every scoring, from the git history.

Run ``python -m studies.perception.training_history --json FILE`` in a clone with its whole history.
A card of weights holds the commands and steps of all trainings before its own, and the
hardware and the validation of its own alone: those of the others stand in the cards that earlier
commits had.  Scorings are those that results of earlier commits hold: on judged frames, and on the
few real frames at hand.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.json_rows import OPTIONAL
from studies.answer import answer
from studies.study import ROOT

WEIGHTS = "avsec_gym/perception/weights"
NETWORKS = {
    "dsgn": "dsgn_small",
    "dsgn_medium": "dsgn_medium",
    "stereo_rcnn": "stereo_rcnn_small",
    "pixor": "pixor_small",
    "pointrcnn": "pointrcnn_small",
    "faster_rcnn": "faster_rcnn_small",
    "yolo": "yolo_small",
    "psmnet": "psmnet_small",
    "motion": "motion_small",
    "road_type": "road_type_small",
}
"""The card of each network."""
LEADING = {"pixor": "bev", "faster_rcnn": "2d", "yolo": "2d"}
"""The precision by which a network is judged; of others that in space."""
PLACES = ("studies/results", "docs/results")
"""Where results are, and were."""
_USUAL_BATCH = 4
"""Samples of a step where a command names none."""
_BATCH = re.compile(r"--batch (\d+)")


@dataclass(frozen=True)
class SeenFrames:
    """Frames that a training had, as its card names them; None where the card does not."""

    suite: str | None
    seed: int | None
    assets: str | None
    """The part of the assets; None of a suite: the world's first edition, which had no parts."""
    fingerprint: str | None
    """Fingerprint of the sources of the world."""
    frames: int | None


@dataclass(frozen=True)
class Training:
    """One of the trainings that made a network's weights."""

    network: str
    date: str | None
    """The day of the first commit that has its weights; None where none has."""
    sha256: str | None
    images: int | None
    """Images it saw, each as often as it was seen."""
    minutes: float | None
    images_per_hour: float | None
    seconds_a_step: float | None
    """The mean of all steps."""
    arithmetic: str | None
    """Numbers that it calculated in, and what a step took in each at its start."""
    hardware: str | None
    metric: Mapping[str, float]
    """The metric that leads, on the frames of `measured_on`."""
    learned: Sequence[SeenFrames]
    """What it was trained on; empty: not recorded."""
    validated: Sequence[SeenFrames]
    """What it was validated on while it ran."""
    calibrated: Sequence[SeenFrames]
    """Frames on which `avsec weights calibrate` fitted its scores and measured it anew."""

    @property
    def measured_on(self) -> Sequence[SeenFrames]:
        """The frames of the card's metric."""
        return self.calibrated or self.validated


@dataclass(frozen=True)
class Scoring:
    """A detector's precision on frames that nothing was chosen on, cars, moderate, AP11."""

    date: str
    seed: int | None
    assets: str
    frames: int
    network: str
    sha256: str
    metric: str
    """``3d``, ``bev`` or ``2d``: in space, from above, in the image."""
    iou70: float
    iou50: float
    interval70: Sequence[float]


@dataclass(frozen=True)
class DisparityScoring:
    """How much more often a preset of PSMNet is wrong than matching, where that finds something."""

    date: str
    seed: int | None
    """Seed of the suite; None: not recorded."""
    pairs: int
    preset: str
    size: Sequence[int]
    """Height and width that it reduced images to, pixels."""
    sha256: str
    more_wrong: float
    """Share of those pixels that is off by more than 3, less that of semi-global matching."""
    interval: Sequence[float]


@dataclass(frozen=True)
class RealScoring:
    """What a detector found in real frames, of the moderate cars there."""

    date: str
    network: str
    sha256: str
    frames: int
    found: int
    missed: int
    false_alarms: int


@dataclass(frozen=True)
class TrainingHistory:
    """The result, each part in the order of time."""

    trainings: Sequence[Training]
    scorings: Sequence[Scoring]
    real: Sequence[RealScoring]
    disparity: Sequence[DisparityScoring] = field(default=(), metadata=OPTIONAL)


class KeptFile(NamedTuple):
    """A file as a commit has it."""

    date: str
    content: Mapping[str, Any]
    second: int = 0
    """The time of the commit, seconds since 1970: several commits may be of one day."""


def run(options: argparse.Namespace) -> TrainingHistory:
    """Read the history.

    Raises:
        ConfigurationError: This is no clone with its history.
    """
    return TrainingHistory(
        [row for name, card in NETWORKS.items() for row in trainings_of(name, _cards(card))],
        [
            *scorings(_results("detectors.json")),
            *scorings(_results("single_sensor_detectors.json")),
        ],
        [
            *real_of_stereo(_results("real_frames.json"), list(_results("detectors.json"))),
            *real_of_one_sensor(_results("single_sensor_detectors.json")),
        ],
        list(disparity_scorings(_results("disparity.json"))),
    )


def trainings_of(network: str, cards: Sequence[KeptFile]) -> list[Training]:
    """The trainings that made the last card's weights, one after the other.

    Args:
        network: The network's name.
        cards: Its cards, as commits brought them, the last of them last.
    """
    if not cards:
        return []
    # The first commit brought the weights; the last card of them knows most.
    of_weights = {kept.content["sha256"]: kept for kept in cards}
    dates = {kept.content["sha256"]: kept.date for kept in reversed(cards)}
    last = cards[-1].content
    rows = []
    for step in [*last.get("before", ()), last]:
        sha256 = step.get("sha256")
        card = of_weights[sha256].content if sha256 in of_weights else {}
        learned, validated, calibrated = _seen(card.get("data", {}))
        rows.append(
            Training(
                network,
                dates.get(sha256),
                sha256,
                _images(step, card),
                card.get("minutes", step.get("minutes")),
                card.get("images_per_hour"),
                _seconds_a_step(card),
                card.get("arithmetic"),
                card.get("hardware"),
                dict(list(card.get("metrics", {}).items())[:1]),
                learned,
                validated,
                calibrated,
            )
        )
    return rows


def scorings(results: Iterator[KeptFile]) -> Iterator[Scoring]:
    """The scorings that were new in each version of a result.

    Weights that are scored again on the same frames, by changed code, are there once more if the
    figures differ.

    Args:
        results: The versions, in the order of time, of the result of `detector_precision` or of
            `single_sensor_precision`.
    """
    seen = set()
    for kept in results:
        data = kept.content["data"]
        for network, found in kept.content["detectors"].items():
            sha256 = found["weights"]["sha256"]
            metric = LEADING.get(network, "3d")
            precision = {iou: found["average_precision"][iou][metric] for iou in ("0.7", "0.5")}
            figures = [round(each["ap11"][1], 1) for each in precision.values()]
            key = data["fingerprint"], data["seed"], sha256, *figures
            if key in seen:
                continue
            seen.add(key)
            yield Scoring(
                kept.date,
                data["seed"],
                data.get("assets") or "all",
                data["frames"],
                network,
                sha256,
                metric,
                precision["0.7"]["ap11"][1],
                precision["0.5"]["ap11"][1],
                precision["0.7"]["ap11_interval"][1],
            )


def disparity_scorings(results: Iterator[KeptFile]) -> Iterator[DisparityScoring]:
    """The scorings that were new in each version of the result of `disparity_accuracy`.

    Args:
        results: The versions, in the order of time; the first ones were not compared with matching.
    """
    seen = set()
    for kept in results:
        world = kept.content.get("world") or {}
        for name, found in world.get("estimators", {}).items():
            size = kept.content.get("input_sizes", {}).get(name)
            if size is None or "more_wrong" not in found:
                continue
            sha256 = kept.content["weights"]["sha256"]
            key = name, sha256, *size, found["more_wrong"]
            if key not in seen:
                seen.add(key)
                yield DisparityScoring(
                    kept.date,
                    kept.content.get("seed"),
                    world["pairs"],
                    name.removeprefix("psmnet_"),
                    size,
                    sha256,
                    found["more_wrong"],
                    found["more_wrong_interval"],
                )


def real_of_stereo(
    results: Iterator[KeptFile], precisions: Sequence[KeptFile]
) -> Iterator[RealScoring]:
    """What stereo detectors found in real frames, by the last result of each weights.

    Args:
        results: Versions of the result of `real_frames`.
        precisions: Versions of that of `detector_precision`, which name the weights of the time.
    """
    rows: dict[tuple[str, str], RealScoring] = {}
    for kept in results:
        before = [each for each in precisions if each.second <= kept.second]
        for network, found in kept.content["detectors"].items():
            weights = [
                each.content["detectors"][network]["weights"]["sha256"]
                for each in before
                if network in each.content["detectors"]
            ]
            counts = list(found["frames"].values())
            numbers = [sum(frame[key] for frame in counts) for key in _COUNTS]
            if weights:
                _keep(rows, RealScoring(kept.date, network, weights[-1], len(counts), *numbers))
    yield from rows.values()


def real_of_one_sensor(results: Iterator[KeptFile]) -> Iterator[RealScoring]:
    """What detectors of one sensor found in real frames, by the last result of each weights.

    Args:
        results: Versions of the result of `single_sensor_precision`.
    """
    rows: dict[tuple[str, str], RealScoring] = {}
    for kept in results:
        for network, found in kept.content["detectors"].items():
            sha256, real = found["weights"]["sha256"], found.get("real")
            if real:
                # Once a number, then their names.
                frames = real["frames"] if isinstance(real["frames"], int) else len(real["frames"])
                numbers = [real[key] for key in _COUNTS]
                _keep(rows, RealScoring(kept.date, network, sha256, frames, *numbers))
    yield from rows.values()


def _keep(rows: dict[tuple[str, str], RealScoring], found: RealScoring) -> None:
    """Let a later result of the same weights take the place of an earlier one, if it differs."""
    key = found.network, found.sha256
    if key not in rows or replace(found, date=rows[key].date) != rows[key]:
        rows[key] = found


_COUNTS = ("found", "missed", "false_alarms")


def _images(step: Mapping[str, Any], card: Mapping[str, Any]) -> int | None:
    """Images that a training saw: as its card counted, or by steps and their size."""
    if card.get("samples_seen"):
        return int(card["samples_seen"])
    if step.get("steps") is None:
        return None
    given = _BATCH.search(step.get("command") or "")
    return int(step["steps"]) * (int(given[1]) if given else _USUAL_BATCH)


def _seconds_a_step(card: Mapping[str, Any]) -> float | None:
    """The mean of the steps of a card."""
    seconds, steps = card.get("compute_seconds"), card.get("steps")
    return round(seconds / steps, 3) if seconds and steps else None


def _seen(data: Mapping[str, Any]) -> tuple[list[SeenFrames], list[SeenFrames], list[SeenFrames]]:
    """What a card's data were learned from, validated on, and calibrated on."""
    if "sources" in data:
        # A classifier holds out scenes of the same sources.
        both = [_frames(source) for source in data["sources"]]
        return both, both, []
    learned, validated, calibrated = (
        [_frames(source) for source in data.get(part, ())]
        for part in ("training", "validation", "calibration")
    )
    return learned, validated, calibrated


def _frames(source: Mapping[str, Any]) -> SeenFrames:
    settings = source.get("settings") or {}
    return SeenFrames(
        suite=settings.get("suite"),
        seed=settings.get("seed"),
        assets=settings.get("assets"),
        fingerprint=source.get("fingerprint"),
        frames=source.get("frames"),
    )


def _cards(name: str) -> list[KeptFile]:
    return list(_versions([f"{WEIGHTS}/{name}.json"]))


def _results(name: str) -> Iterator[KeptFile]:
    return _versions([f"{place}/{name}" for place in PLACES])


def _versions(paths: Sequence[str]) -> Iterator[KeptFile]:
    """A file as each commit left it, the oldest first."""
    log = _git("log", "--reverse", "--format=%H %cs %ct", "--", *paths)
    for line in log.splitlines():
        commit, date, second = line.split()
        for path in paths:
            if text := _git("show", f"{commit}:{path}", may_fail=True):
                yield KeptFile(date, json.loads(text), int(second))
                break


def _git(*words: str, may_fail: bool = False) -> str:
    found = subprocess.run(["git", *words], capture_output=True, text=True, cwd=ROOT, check=False)
    if found.returncode and not may_fail:
        raise ConfigurationError(
            f"the history is read from a git clone, and git reports: {found.stderr.strip()}"
        )
    return "" if found.returncode else found.stdout


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
