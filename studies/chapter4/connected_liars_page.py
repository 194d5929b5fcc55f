"""What `connected_liars` found, as a page.

Run ``python -m studies.chapter4.connected_liars_page RESULT.json --out PAGE.md``.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from avsec_gym.report.markdown_table import markdown_table
from studies.chapter4.connected_liars import ConnectedLiars
from studies.chapter4.shares import percent
from studies.page_of_result import page_of_result

_COMMAND = "python -m studies.chapter4.connected_liars --json FILE"


def liars_page(result: ConnectedLiars) -> str:
    """Markdown: how often one vehicle that lies has an honest one named.

    Args:
        result: The result of `connected_liars`.
    """
    rows = [
        [
            row.method,
            str(row.vehicles),
            str(row.liars) + (" (the default)" if not row.liars else ""),
            percent(row.alone),
            percent(row.convicted),
        ]
        for row in result.rows
    ]
    columns = ["method", "vehicles", "liars reckoned with"]
    columns += ["named while the liar is silent, %", "named when it lies, %"]
    between = " and ".join(
        f"{percent(share)} with {vehicles} vehicles"
        for vehicles, share in sorted(result.contradicted.items())
    )
    return "\n".join(
        [
            "# One vehicle that lies",
            "",
            f"Made by `{_COMMAND}`, shown by its `page`: {result.places} attack-free places of the"
            " judging assets at the usual errors (positions 0.2 m, headings 0.2 degrees, clocks up"
            f" to 0.1 s apart), seed {result.seed}, the package’s own fit. The last vehicle makes"
            " up all that it sends, after it has heard the others. **By rays** it lies about the"
            " three regions in which honest vehicles contradict each other most, once denying and"
            " once supporting what another one’s rays pass through; CMA-ES then bends the best of"
            f" these lies, {result.evaluations} evaluations at most. **By surfaces** it sends the"
            " surfaces of another vehicle, each in turn, in all regions. It counts whether an"
            " honest vehicle is named in any region. In brackets: 95 % intervals; a place stands"
            " in each row once.",
            "",
            *markdown_table(columns, rows),
            "",
            "Of three vehicles two can accuse: reckoned with one liar, none is ever named, and so"
            " there is no row. Honest vehicles contradict each other, by more than twice as many"
            f" rays that pass through a claim as support it, in this share of instants: {between}.",
            "",
        ]
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    return page_of_result(
        arguments,
        ConnectedLiars,
        liars_page,
        maker="connected_liars",
        what=__doc__,
        remedy=_COMMAND,
    )


if __name__ == "__main__":
    sys.exit(main())
