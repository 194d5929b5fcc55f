"""The page of `patch_signal`, as Markdown.

Run ``python -m studies.chapter5.patch_signal_page FILE --out PAGE``.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from avsec_gym.drawing.page_table import number
from avsec_gym.report.markdown_table import markdown_table
from studies.chapter5.patch_signal import NEAR, PatchEffect, PatchSignals
from studies.page_of_result import page_of_result

_HEADINGS = (
    "detector", "common share of gradients, %", "places to outweigh the rest", "patch", "loss",
    "score", "seen, %",
)  # fmt: skip


def signal_page(result: PatchSignals) -> str:
    """The page.

    Args:
        result: The result of `patch_signal`.
    """
    rows = []
    for name, signal in result.detectors.items():
        needed = signal.places_to_learn
        about = [
            f"`{name}`",
            number(100 * signal.common, digits=1),
            "none found" if needed is None else number(needed, digits=0),
        ]
        for patch, effect in (
            ("plain grey", signal.grey),
            ("a picture of a car", signal.pictures),
            ("plain grey, at own places", signal.own_before),
            ("trained there, for this place alone", signal.own_after),
        ):
            rows.append([*about, patch, *_cells(effect)])
            about = ["", "", ""]
    return "\n".join(
        [
            "# What a patch has to learn from",
            "",
            f"Procedural frames with judging assets ({result.frames}), patches of the usual size at"
            " random places, the loss to the ghost alone. A patch that is to work anywhere descends"
            " along what the gradients of all places have in common: their common share"
            f" ({result.gradients} places, plain grey, each gradient scaled to one mean size) tells"
            " over how many places that outweighs the rest. *Score*: mean of the highest score of"
            f" a box within {NEAR:g} m of the ghost’s middle, where no real object is near;"
            f" *seen*: share of places with such a box of 0.5 or more. Pictures of"
            f" {result.pictures} cars, cut out of other places of these frames, at"
            f" {result.judged} places; {result.own} places with a patch of their own, trained for"
            f" {result.steps} steps.",
            "",
            *markdown_table(_HEADINGS, rows),
            "",
        ]
    )


def _cells(effect: PatchEffect) -> list[str]:
    return [
        number(effect.loss, digits=2),
        number(effect.score, digits=2),
        number(100 * effect.seen, digits=0),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    return page_of_result(
        arguments,
        PatchSignals,
        signal_page,
        maker="patch_signal",
        what=__doc__,
        remedy="Make it with `python -m studies.chapter5.patch_signal --world DIR --json FILE`.",
    )


if __name__ == "__main__":
    sys.exit(main())
