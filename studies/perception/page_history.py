"""Parts of detectors.md on how the weights came about, and on every scoring."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

from avsec_gym.report.markdown_table import UNKNOWN, markdown_table, number
from studies.perception.page_frames import frames_in_words
from studies.perception.training_history import (
    DisparityScoring,
    RealScoring,
    Scoring,
    Training,
    TrainingHistory,
)

Row = TypeVar("Row", Training, RealScoring)
_LEADING = {
    "Car_3d_ap11": "AP11 in space",
    "Car_3d_ap40": "AP40 in space",
    "Car_bev_ap40": "AP40 from above",
    "Car_2d_ap40": "AP40 in the image",
    "right_3px": "right to 3 px and 5 %",
    "accuracy": "accuracy",
}
"""The metric that leads in a card."""
_VIEWS = {"3d": "in space", "bev": "from above", "2d": "in the image"}
_STEPS = re.compile(
    r"(?P<numbers>\w+): a step took (?P<float32>[\d.]+) s in float32,"
    r" (?P<bfloat16>[\d.]+) s in bfloat16"
)
"""What a card states of the numbers that a training calculated in."""


def trainings(history: TrainingHistory) -> list[str]:
    """Each training of the shipped weights: images, hardware, time, and what came of it."""
    rows = []
    for network, legs in _by_network(history.trainings).items():
        seen = 0
        for leg in legs:
            seen += leg.images or 0
            rows.append(
                [
                    f"`{network}`",
                    leg.date or UNKNOWN,
                    frames_in_words(leg.learned) or UNKNOWN,
                    number(leg.images, 0),
                    number(seen, 0),
                    leg.hardware or UNKNOWN,
                    number(leg.minutes, 0),
                    number(leg.images_per_hour, 0),
                    _metric(leg.metric),
                    frames_in_words(leg.measured_on) or UNKNOWN,
                ]
            )
    return [
        "## How the weights came about",
        "",
        "Each training of the weights in the package, from the cards that git's history holds: the"
        " images that the network has seen, the computing that it took, and the precision that its"
        " card states, with the frames that it was measured on: those that its scores were"
        " calibrated on, or else those that it was validated on. These differ between trainings, so"
        " that a step may be the frames'. A dash: weights that no commit brought, of which the next"
        " card states the command and the steps alone.",
        "",
        *markdown_table(
            ["network", "committed", "trained on", "images", "in all", "hardware", "minutes",
             "images an hour", "precision", "measured on"],
            rows,
        ),
        "",
        f"In all {_computing(history.trainings)}. Trainings whose weights were not kept are no part"
        f" of it, nor are rendering and calibrating.{_pace(history.trainings)}",
    ]  # fmt: skip


def every_scoring(scorings: Sequence[Scoring]) -> list[str]:
    """All scorings of detectors, whichever weights and frames."""
    rows = [
        [
            each.date,
            f"{each.seed}",
            each.assets,
            number(each.frames, 0),
            f"`{each.network}`",
            f"`{each.sha256[:8]}`",
            _VIEWS[each.metric],
            f"{each.iou70:.1f} ({each.interval70[0]:.1f} to {each.interval70[1]:.1f})",
            number(each.iou50, 1),
        ]
        for each in scorings
    ]
    return [
        "## Every scoring",
        "",
        "AP11 of cars, moderate, of every version of this page, with intervals over the frames of"
        " one seed. Frames of seed 2 are of the first edition of the world and all its"
        " assets; all others are of judging assets. How far the figures of one network differ"
        " between seeds shows what 400 frames decide. Weights that are there twice with one seed"
        " were scored again, by changed code.",
        "",
        *markdown_table(
            ["date", "seed", "assets", "frames", "detector", "weights", "AP11", "IoU 0.7",
             "IoU 0.5"],
            rows,
        ),
    ]  # fmt: skip


def every_disparity(scorings: Sequence[DisparityScoring]) -> list[str]:
    """All scorings of PSMNet beside semi-global matching, whichever weights and pairs."""
    if not scorings:
        return []
    rows = [
        [
            each.date,
            UNKNOWN if each.seed is None else f"{each.seed}",
            number(each.pairs, 0),
            f"`{each.preset}`, {each.size[1]} x {each.size[0]}",
            f"`{each.sha256[:8]}`",
            f"{100 * each.more_wrong:.2f} ({100 * each.interval[0]:.2f} to"
            f" {100 * each.interval[1]:.2f})",
        ]
        for each in scorings
    ]
    return [
        "Every scoring of PSMNet: points by which it is more often off by more than 3 pixels than"
        " matching where that finds something. A dash: the seed was not recorded; these pairs are"
        " of seed 118205, all of them the same, looked at between trainings and before the size of"
        " `small` was changed. Those with a seed were scored once.",
        "",
        *markdown_table(
            ["date", "seed", "pairs", "preset and size", "weights", "> 3 px more, points"], rows
        ),
    ]


def real_then_and_now(scorings: Sequence[RealScoring]) -> list[str]:
    """What networks find in real frames: the first and the present weights."""
    rows = []
    for network, found in _by_network(scorings).items():
        first, now = found[0], found[-1]
        if first.sha256 == now.sha256:
            continue  # There is nothing to compare with.
        rows.append(
            [
                f"`{network}`",
                number(now.frames, 0),
                *_found(first),
                *_found(now),
                "fewer" if now.found < first.found else "as many" if now.found == first.found
                else "more",
            ]
        )  # fmt: skip
    return [
        "## Real frames, then and now",
        "",
        "Moderate cars found in the real frames at hand, by the first weights of which there is a"
        " result and by those in the package, each from its own working point; networks whose"
        " weights have not changed since their first result are left out. So few cars decide"
        " nothing: one more or less is one of these.",
        "",
        *markdown_table(
            ["detector", "frames", "first: found", "false alarms", "now: found", "false alarms",
             "now finds"],
            rows,
        ),
    ]  # fmt: skip


def _found(scoring: RealScoring) -> list[str]:
    of = scoring.found + scoring.missed
    return [f"{scoring.found} of {of} ({scoring.date})", str(scoring.false_alarms)]


def _by_network(rows: Iterable[Row]) -> dict[str, list[Row]]:
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.network, []).append(row)
    return found


def _metric(metrics: Mapping[str, float]) -> str:
    for name, value in metrics.items():
        # An accuracy is a share of 1, everything else is in percent.
        percent = 100 * value if name == "accuracy" else value
        return f"{_LEADING.get(name, name)} {number(percent, 1)}"
    return UNKNOWN


def _pace(trainings: Sequence[Training]) -> str:
    """How long a step took on a processor: at the begin, and on the average."""
    rows = []
    for leg in trainings:
        begun = _STEPS.fullmatch(leg.arithmetic or "")
        if leg.seconds_a_step is None or begun is None or "processor" not in (leg.hardware or ""):
            continue
        numbers = begun["numbers"]
        rows.append(
            f"`{leg.network}` {leg.date} ({number(leg.images_per_hour, 0)} images an hour)"
            f" {leg.seconds_a_step:.1f} s on the average, and {float(begun[numbers]):.1f} s when it"
            f" was measured at the start ({numbers})"
        )
    if not rows:
        return ""
    return (
        f" On a processor, a step took, by the cards: {'; '.join(rows)}. What else ran on the"
        " machine they do not state."
    )


def _computing(trainings: Sequence[Training]) -> str:
    """Hours by hardware."""
    hours: dict[str, float] = {}
    for each in trainings:
        where = each.hardware or "hardware that no card states"
        hours[where] = hours.get(where, 0.0) + (each.minutes or 0.0) / 60
    return ", ".join(f"{number(spent, 1)} hours on {where}" for where, spent in hours.items())
