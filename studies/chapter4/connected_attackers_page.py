"""What `connected_attackers` found, as a page.

Run ``python -m studies.chapter4.connected_attackers_page RESULT.json --out PAGE.md``.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence

from avsec_gym.report.markdown_table import markdown_table, number
from studies.chapter4.connected_attackers import RATE, VEHICLES, ConnectedAttackers
from studies.chapter4.shares import percent
from studies.page_of_result import page_of_result

_COMMAND = "python -m studies.chapter4.connected_attackers --json FILE"
_WORDS = {
    "anywhere": "a ghost anywhere",
    "blind_spot": "where the others see least",
    "path": "in the victim’s path",
    "sun_2020": "anywhere, 200 points (Sun et al. 2020)",
    "cao_2019": "anywhere, 60 points (Cao et al. 2019)",
    "two_victims": "two victims, a ghost each",
    "same_ghost": "two victims, the same ghost",
}


def attackers_page(result: ConnectedAttackers) -> str:
    """Markdown: what attackers get through, and who is named.

    Args:
        result: The result of `connected_attackers`.
    """
    tables = [line for vehicles in VEHICLES for line in _tables(result, vehicles)]
    return "\n".join(
        [
            "# Attackers of connected vehicles",
            "",
            f"Made by `{_COMMAND}`, shown by its `page`: {result.places} places of the judging"
            " assets at the usual errors (positions 0.2 m, headings 0.2 degrees, clocks up to 0.1 s"
            f" apart), seed {result.seed}, by rays. An attack is detected where the score of a"
            f" decidable region about it exceeds what {100 * RATE:g} % of the decidable attack-free"
            " regions of as many places of the training assets exceed. Named is who the package’s"
            " own fit names, in the decidable region about the attack with the highest score. Of"
            " two victims each ghost is an attack, and both are victims. In brackets: 95 %"
            " intervals, in which a place is a cluster.",
            "",
            *tables,
            "A ghost that no other vehicle’s rays reach is not decidable, which an attacker who"
            " knows the method aims at: beside what is detected of the decidable ones stands what"
            " is detected of all. Two victims with the same ghost confirm each other, and each"
            " honest vehicle that sees through it contradicts both.",
            "",
        ]
    )


def _tables(result: ConnectedAttackers, vehicles: int) -> Iterator[str]:
    rows = [row for row in result.rows if row.vehicles == vehicles]
    [clean] = [row for row in result.clean if row.vehicles == vehicles]
    yield f"## {vehicles} vehicles"
    yield ""
    yield (
        f"Without an attack {percent(clean.regions)} of the decidable regions exceed the threshold"
        f" of {number(clean.threshold, 2)} (in %), and {percent(clean.instants)} of the instants"
        f" have one that does; a vehicle is named in {percent(clean.named)} of them."
    )
    yield ""
    columns = ["attack", "points", "covered, %", "decidable, %", "detected of all, %"]
    columns += ["detected of decidable, %"]
    yield from markdown_table(
        columns,
        [
            [
                _WORDS[row.attacker],
                number(row.points, 0),
                *map(percent, (row.covered, row.decidable, row.end_to_end, row.detected)),
            ]
            for row in rows
        ],
    )
    yield ""
    columns = ["attack", "a victim is named, % of decidable", "another is, % of decidable"]
    columns += ["one that is no victim is named anywhere, % of instants"]
    yield from markdown_table(
        columns,
        [
            [_WORDS[row.attacker], *map(percent, (row.victim, row.another, row.wrongly))]
            for row in rows
        ],
    )
    yield ""


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    return page_of_result(
        arguments,
        ConnectedAttackers,
        attackers_page,
        maker="connected_attackers",
        what=__doc__,
        remedy=_COMMAND,
    )


if __name__ == "__main__":
    sys.exit(main())
