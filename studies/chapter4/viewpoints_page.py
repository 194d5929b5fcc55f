"""Result and page of `viewpoints`.

Run ``python -m studies.chapter4.viewpoints_page --samples FILE --markdown FILE --json FILE``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from avsec_gym.console import progress
from avsec_gym.report.markdown_table import markdown_table, number
from avsec_gym.storage.json_lines import JsonLines
from avsec_gym.storage.text_files import write_text
from studies.answer import answer
from studies.chapter4.shares import percent
from studies.chapter4.viewpoint_rates import BOUND, RATES, ViewpointRates, WayRow, viewpoint_rates
from studies.chapter4.viewpoints import (
    DELAUNAY,
    GHOST,
    OPTIMISED_PLACES,
    OPTIMISED_REGIONS,
    REMOVAL,
    SEED,
    SIDES,
    VIEWPOINTS,
    KeptPlace,
    measured_places,
)

PLACES = 60
THESIS = {0.1: 0.70, 0.3: 0.90}
"""The thesis' detection rates by false positive rate: "very close to", and "over"."""


def viewpoints_page(result: ViewpointRates) -> str:
    """The page.

    Args:
        result: The rates.
    """
    return "\n".join(
        [
            "# Surfaces, by where the vehicles look from",
            "",
            f"The thesis' method at {result.places} places to take thresholds from and"
            f" {result.places} others, of other assets, to judge; poses exact. *One vehicle, 0.5 s"
            " apart*: the thesis' own data, three successive scans of a vehicle that passes, of"
            " regions near which nothing moves. *Three vehicles*: they meet on the road, 15 to 60 m"
            " apart. Regions are proposals of all vehicles; *beside* is what is cropped beside"
            " them. Theta is that of a designated share r of attack-free pairs. An attack is"
            " detected where a distance between the victim and another vehicle lies beyond theta,"
            " of attacks that a proposal is about and whose surfaces were compared. In brackets:"
            " 95 % intervals over places.",
            "",
            *(_sentence(result, viewpoints) for viewpoints in VIEWPOINTS),
            "",
            *_detection_table(result, GHOST),
            *_detection_table(result, REMOVAL),
            *_distance_table(result),
            "## Attacks that a proposal is about",
            "",
            *markdown_table(
                ["viewpoints", "attack", "covered, %"],
                [[each.viewpoints, each.attack, percent(each.covered)] for each in result.covers],
            ),
            "",
            "## What surfaces cost",
            "",
            f"All surfaces of a region, three of them. Optimised meshes were made at the first"
            f" {OPTIMISED_PLACES} places of each part, of {OPTIMISED_REGIONS} regions of each state"
            " at most: their rates are those of few regions.",
            "",
            *markdown_table(
                ["surfaces", "regions", "a region, ms"],
                [
                    [each.mesher, f"{each.regions}", number(1000 * each.seconds, 1)]
                    for each in result.times
                ],
            ),
            "",
        ]
    )


def _sentence(result: ViewpointRates, viewpoints: str) -> str:
    """How the thesis' figures stand to ghosts, by the first mesher and crops without margins."""
    row = next(
        each
        for each in result.ways
        if (each.viewpoints, each.mesher, each.sides, each.attack)
        == (viewpoints, DELAUNAY, SIDES[0], GHOST)
    )
    parts = []
    for each in row.detection:
        reached = each.detected.rate is not None and each.detected.rate >= THESIS[each.rate]
        parts.append(
            f"{percent(each.detected)} ghosts (in %) detected at r = {each.rate:g}"
            f" ({'as' if reached else 'less than'} in the thesis, {100 * THESIS[each.rate]:.0f} %)"
        )
    clean = row.clean_below.rate is not None and row.clean_below.rate > 0.5
    above = row.attacked_above.rate is not None and row.attacked_above.rate > 0.5
    bound = (
        "most attack-free distances lie below"
        if clean
        else "most attack-free distances do not lie below"
    )
    return (
        f"- **{viewpoints}**: {'; '.join(parts)}; {bound} {BOUND:g} m, and most of a ghost's"
        f" {'above' if above else 'do not lie above'} it."
    )


def _detection_table(result: ViewpointRates, attack: str) -> Iterator[str]:
    yield f"## {attack.capitalize()}s"
    yield ""
    columns = ["viewpoints", "surfaces", "beside, m", "compared, %"]
    for rate in RATES:
        columns += [f"theta at r = {rate:g}, m", "false alarms, %", "detected, %"]
    rows = []
    for way in (each for each in result.ways if each.attack == attack):
        cells = [way.viewpoints, way.mesher, f"{way.sides:g}", percent(way.compared)]
        for each in way.detection:
            cells += [number(each.theta, 2), percent(each.false_alarms), percent(each.detected)]
        rows.append(cells)
    yield from markdown_table(columns, rows)
    yield ""


def _distance_table(result: ViewpointRates) -> Iterator[str]:
    yield "## Distances"
    yield ""
    yield from markdown_table(
        [
            "viewpoints",
            "surfaces",
            "beside, m",
            "attack",
            f"attack-free below {BOUND:g} m, %",
            f"with the victim above {BOUND:g} m, %",
            "median with the victim, m",
        ],
        [_distances(each) for each in result.ways],
    )
    yield ""


def _distances(way: WayRow) -> list[str]:
    return [
        way.viewpoints,
        way.mesher,
        f"{way.sides:g}",
        way.attack,
        percent(way.clean_below),
        percent(way.attacked_above),
        number(way.median, 2),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, print rates as JSON, write the page; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--places", type=int, default=PLACES, help="of each part")
    parser.add_argument("--seed", type=int, default=SEED, help="of the places")
    parser.add_argument(
        "--samples", type=Path, default=Path("runs/connected_viewpoints/samples.jsonl"),
        help="what was measured of each place",
    )  # fmt: skip
    parser.add_argument("--markdown", type=Path, help="also write the page into this file")
    parser.add_argument("--json", type=Path, help="write here instead of standard output")

    def made(options: argparse.Namespace) -> ViewpointRates:
        kept = JsonLines(options.samples, KeptPlace)
        with progress("comparing surfaces") as shown:
            places = measured_places(options.places, kept, options.seed, shown)
        result = viewpoint_rates(places, options.seed)
        if options.markdown is not None:
            write_text(options.markdown, viewpoints_page(result), overwrite=True)
        return result

    return answer(parser.parse_args(arguments), made)


if __name__ == "__main__":
    sys.exit(main())
