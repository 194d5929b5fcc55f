"""What `connected_real` found, as a page.

Run ``python -m studies.chapter4.connected_real_page RESULT.json --out PAGE.md``.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from avsec_gym.report.markdown_table import markdown_table, number
from studies.chapter4.connected_real import PICTURES, ConnectedReal, RealDecision
from studies.page_of_result import page_of_result

_COMMAND = "python -m studies.chapter4.connected_real --kitti ROOT --json FILE"


def real_page(result: ConnectedReal) -> str:
    """Markdown: an anecdote of three triples.

    Args:
        result: The result of `connected_real`.
    """
    scans = [
        [
            _frame(scan.middle),
            str(scan.frame),
            number(scan.ahead, 2),
            number(100 * scan.residual, 1),
            number(100 * scan.overlap, 0),
        ]
        for scan in result.scans
    ]
    columns = ["middle scan", "frame", "ahead of it, m", "residual, cm"]
    columns += ["upright surfaces that agree, %"]
    decisions = [_decision(row) for row in result.decisions]
    triples = len({scan.middle for scan in result.scans})
    titles = ["middle scan", "state", "by", "points", "regions (decidable)", "score"]
    titles += ["about the attack", "alarms elsewhere", "named"]
    return "\n".join(
        [
            "# Three real triples of scans",
            "",
            f"**An anecdote, no rate**: {triples} triples of one street, drive {result.drive} of"
            f" KITTI’s raw data. Made by `{_COMMAND}`, shown by its `page`. Three"
            " scans half a second apart stand for three vehicles, as in the thesis; there are no"
            " measured poses, so the scans are registered onto the middle one. Into that (vehicle"
            " 1) a ghost is pasted, or an object is removed from it, three draws of each."
            " By rays each is judged twice: as what may have moved meanwhile, and *still*, as the"
            " thesis assumes; surfaces know of no motion. Traffic does move in this street: where"
            " all is taken to stand, alarms elsewhere are to be expected. What decides is the"
            " package’s own fit, of the procedural world.",
            "",
            *markdown_table(columns, scans),
            "",
            "The residual is the median distance of a scan’s points from the middle scan’s"
            " surface.",
            "",
            *markdown_table(titles, decisions),
            "",
            *[
                f"![From above, {state}: what vehicles claim, and rays that pass through]({name})"
                for state, name in PICTURES.items()
            ],
            "",
        ]
    )


def _decision(row: RealDecision) -> list[str]:
    by = f"{row.method}, still" if row.method == "rays" and row.still else row.method
    return [
        _frame(row.id),
        row.state,
        by,
        str(row.points or "–"),
        f"{row.regions} ({row.decidable})",
        number(row.score, 2),
        row.about or "–",
        str(row.alarms),
        ", ".join(map(str, row.accused)) or "none",
    ]


def _frame(id: str) -> str:
    """The number of a triple's middle frame."""
    return str(int(id.rpartition("/")[2]))


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    return page_of_result(
        arguments, ConnectedReal, real_page, maker="connected_real", what=__doc__, remedy=_COMMAND
    )


if __name__ == "__main__":
    sys.exit(main())
