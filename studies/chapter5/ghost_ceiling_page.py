"""What a ghost of a size costs at a distance: result, page and picture of `ghost_ceiling`.

Run ``python -m studies.chapter5.ghost_ceiling_page --scenarios DIR --json FILE``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from avsec_gym.console import progress
from avsec_gym.experiments.thesis import SAFETY
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.report.markdown_table import interval, markdown_table, number
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_sets import labelled_scenarios
from avsec_gym.storage.text_files import write_text
from studies.answer import answer
from studies.chapter5.ghost_ceiling import (
    COUNTS,
    DISTANCES,
    WIDTHS,
    GhostCeilings,
    ghost_ceilings,
    kind_in_words,
    safe_interval,
)
from studies.chapter5.ghost_ceiling_figure import draw_ceilings

PICTURE = "images/ghost_ceiling.png"
"""The picture beside the page."""


@dataclass(frozen=True)
class PrototypeCeiling:
    """What the first round's prototype had for full ghosts, whose places it drew in its own way.

    Args:
        ghosts: Number of ghosts at once.
        distances: Least and largest distance, metres.
        safe: Safe driving rate in %, keeping the lane.
    """

    ghosts: int
    distances: tuple[float, float]
    safe: float


PROTOTYPE = (
    PrototypeCeiling(1, (8.0, 20.0), 88.0),
    PrototypeCeiling(1, (5.0, 12.0), 62.0),
    PrototypeCeiling(2, (5.0, 12.0), 34.0),
)


def ceiling_page(result: GhostCeilings) -> str:
    """The page.

    Args:
        result: The result of `ghost_ceiling`.
    """
    tables = [line for intention in Intention for line in _table(result, intention)]
    return "\n".join(
        [
            "# What a ghost can cost",
            "",
            f"The planner gets the labelled objects of {result.scenarios:,} scenarios, and one or"
            " two ghosts beside them that stand still and head as the car does: what a patch costs"
            " that works every time, whichever detector it is made for. A ghost’s rear stands at a"
            " distance that is uniform in the range, in a column of the third of the image that the"
            " driving intention points to, as a specific patch does. *As seen* is as wide as a"
            " patch of 38 pixels shows at that distance, up to a full car; all have the proportions"
            " of KITTI’s mean car, 1.63 m wide. Ghosts of all sizes stand at the same places. Safe"
            " driving in %, A*, moving objects known; in brackets: Wilson’s 95 % intervals over"
            " scenarios.",
            "",
            f"![Safe driving over the distance of ghosts, one panel for each intention]({PICTURE})",
            "",
            _prototype(result),
            "",
            *_thesis(result),
            *tables,
            "What this does not bound: an attacker may choose the worst place of a scene instead of"
            " one at random, and a patch may hide objects, or have ghosts elsewhere than at its"
            " place.",
            "",
        ]
    )


def _table(result: GhostCeilings, intention: Intention) -> Iterator[str]:
    yield f"## {str(intention).capitalize()}"
    yield ""
    ranges = [f"{nearest:g} to {farthest:g} m" for nearest, farthest in DISTANCES]
    lines = [
        [
            kind_in_words(count, width),
            *(_safe(row.rates) for row in result.of(intention, count, width)),
        ]
        for count in COUNTS
        for width in WIDTHS
    ]
    lines.append(["no ghost", *[_safe(result.alone(intention))] * len(DISTANCES)])
    yield from markdown_table(["ghosts", *ranges], lines)
    yield ""


def _thesis(result: GhostCeilings) -> Iterator[str]:
    """How far ghosts go towards what the thesis' specific patch costs, intention by intention."""
    lines = []
    for intention in Intention:
        rows = [row for row in result.rows if row.intention == intention]
        thesis = SAFETY["stereo_rcnn", "patch-specific", intention].safe
        alike = [
            f"{row.words} at {row.nearest:g} to {row.farthest:g} m"
            for row in rows
            if safe_interval(row.rates)[0] <= thesis <= safe_interval(row.rates)[1]
        ]
        worst = min(rows, key=lambda row: row.rates.safe_driving_rate)
        lines.append(
            [
                str(intention),
                _safe(result.alone(intention)),
                f"{_safe(worst.rates)}, {worst.words} at {worst.nearest:g} to {worst.farthest:g} m",
                number(100 * thesis, 1),
                "; ".join(alike) or "none",
            ]
        )
    yield "## Beside the thesis’ patch"
    yield ""
    yield (
        "Thesis: Stereo R-CNN under its specific patch, whose car has a detector’s other errors"
        " besides; *as costly*: ghosts whose interval holds the thesis’ figure."
    )
    yield ""
    yield from markdown_table(
        ["intention", "no ghost", "the costliest of these ghosts", "thesis", "as costly"], lines
    )
    yield ""


def _prototype(result: GhostCeilings) -> str:
    """The prototype's figures beside ours."""
    parts = []
    for each in PROTOTYPE:
        (row,) = (
            row
            for row in result.of(Intention.STRAIGHT, each.ghosts, WIDTHS[-1])
            if row.distances == each.distances
        )
        nearest, farthest = each.distances
        parts.append(
            f"{row.words} at {nearest:g} to {farthest:g} m: {each.safe:g}, here {_safe(row.rates)}"
        )
    return (
        "The prototype of the first round drew places in its own way; straight, %:"
        f" {'; '.join(parts)}."
    )


def _safe(rates: SafetyRates) -> str:
    bounds = [100 * bound for bound in safe_interval(rates)]
    return interval(100 * rates.safe_driving_rate, bounds, digits=1)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print rows as JSON, write page and picture; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument(
        "--scenarios", type=Path, required=True, help="the authors' labelled scenarios"
    )
    parser.add_argument("--limit", type=int, help="only the first scenarios")
    parser.add_argument("--seed", type=int, default=0, help="of the ghosts' places")
    parser.add_argument("--markdown", type=Path, help="also write tables into this file")
    parser.add_argument("--figure", type=Path, help="also draw this picture")
    parser.add_argument("--json", type=Path, help="write here instead of standard output")

    def made(options: argparse.Namespace) -> GhostCeilings:
        scenes = labelled_scenarios(options.scenarios).limited(options.limit).labelled
        with progress("planning with ghosts") as shown:
            result = ghost_ceilings(scenes, options.seed, on_progress=shown)
        if options.markdown is not None:
            write_text(options.markdown, ceiling_page(result), overwrite=True)
        if options.figure is not None:
            draw_ceilings(result, options.figure)
        return result

    return answer(parser.parse_args(arguments), made)


if __name__ == "__main__":
    sys.exit(main())
