"""The part of studies/results/detectors.md on the two classifiers."""

from __future__ import annotations

from collections.abc import Mapping

from avsec_gym.errors import DataError
from avsec_gym.report.markdown_table import UNKNOWN, interval, markdown_table, share
from avsec_gym.road_type import RoadType
from studies.perception.classifier_accuracy import (
    Accuracy,
    ClassifierAccuracy,
    RealRoads,
)

_INDEPENDENT = (
    "Wilson's 95 % intervals take objects for independent, though those of one scene are not."
)
_CLUSTERED = (
    "In brackets: 95 % intervals, Wilson's, widened by what the objects of one scene share."
)


def classifiers(found: ClassifierAccuracy) -> list[str]:
    """How often the moving-object classifier and the driving-constraint selector are right.

    Args:
        found: The result of `studies.perception.classifier_accuracy`.
    """
    motion, road = found.motion, found.road_type
    if motion.world is None or road.world is None:
        raise DataError("The result of the classifiers is not of the procedural world.")
    moves, real = motion.world.accuracy, motion.real or {}
    same = moves.single_crop_of_the_same
    standing = moves.with_neighbour.confusion
    stand = standing["no_said_no"] + standing["no_said_yes"]
    rows = [
        _row("moves, with an earlier frame", moves.with_neighbour),
        *(_row(f"… {distance} away", counts) for distance, counts in moves.by_distance.items()),
        _row("moves, by the single crop, the same objects", same, motion.thesis),
    ]
    for name, words in (
        ("flags_of_scenarios", "real frames with the scenarios' flags, by the single crop"),
        ("static_by_list", "real frames that the authors' list calls static, with earlier frames"),
    ):
        if name in real:
            of = real[name].accuracy
            counts = of.single_crop if name == "flags_of_scenarios" else of.with_neighbour
            rows.append(_row(words, counts, motion.thesis))
    rows.append(_row("road type", road.world.accuracy, of_motion=False))
    if road.real:
        rows.append(
            _row("road type, real frames", road.real.accuracy, road.thesis, of_motion=False)
        )
    return [
        "## Who moves, and on what road",
        "",
        f"On {motion.world.scenes} (moving) and {road.world.scenes} (road type) held-out scenes"
        " of the procedural world, and apart from them on the real frames at hand."
        f" {_INDEPENDENT if moves.with_neighbour.clusters is None else _CLUSTERED} Who always said"
        f" “stands” would be right in {share(stand / max(same.cases, 1))} % of the objects"
        " with an earlier frame. The thesis' figures are of its own real crops.",
        *_without_cars(road.real),
        "",
        *markdown_table(
            ["what", "cases", "right, %", "moving called standing, %",
             "standing called moving, %", "thesis, right, %"],
            rows,
        ),
    ]  # fmt: skip


def _without_cars(real: RealRoads | None) -> list[str]:
    """What is said of roads on which there is no car."""
    alone = [each for each in (real.frames if real else ()) if not each.has_cars]
    if not alone:
        return []
    right = sum((each.highway > 0.5) == (each.truth == RoadType.HIGHWAY) for each in alone)
    return [
        "",
        f"Real frames without cars, streets by their scenarios' folder: {right} of {len(alone)} are"
        " called so.",
    ]


def _row(
    words: str, found: Accuracy, thesis: float | None = None, *, of_motion: bool = True
) -> list[str]:
    percent = None if found.accuracy is None else 100 * found.accuracy
    bounds = None if found.interval is None else [100 * bound for bound in found.interval]
    return [
        words,
        str(found.cases),
        interval(percent, bounds),
        *(_errors(found.confusion) if of_motion else ("", "")),
        "" if thesis is None else f"{100 * thesis:.2f}",
    ]


def _errors(confusion: Mapping[str, int]) -> tuple[str, str]:
    """Shares of what moves and is called standing, and the other way round, with their counts."""
    moves, stands = (
        (confusion[f"{truth}_said_no"], confusion[f"{truth}_said_yes"]) for truth in ("yes", "no")
    )
    return _share_of(moves[0], sum(moves)), _share_of(stands[1], sum(stands))


def _share_of(wrong: int, of: int) -> str:
    return f"{share(wrong / of)} ({wrong} of {of})" if of else UNKNOWN
