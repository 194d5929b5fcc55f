"""The page of `fit`, as Markdown.

Run ``python -m studies.driving_safety.error_models.page FILE --out PAGE``.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

from avsec_gym.closed_loop.error_model.check import FOUND_MARGIN, GHOST_MARGIN, Agreement
from avsec_gym.report.markdown_table import UNKNOWN, markdown_table, number
from studies.driving_safety.error_models.result import CheckedModel, CheckedModels
from studies.page_of_result import page_of_result

_COMMAND = "Make it with `python -m studies.driving_safety.error_models.fit --json FILE`."
_FITTED = ("name", "attack", "drives", "frames", "objects", "found, %", "ghosts a frame")
_CHECKED = (
    "name", "metres", "objects", "found, %", "model, %", "ghosts a frame", "model", "answer",
)  # fmt: skip


def error_models_page(result: CheckedModels) -> str:
    """The page.

    Args:
        result: The result of `fit`.
    """
    models = result.models
    answers = [each.answer for model in models for each in model.checks]
    agree, differ, unknown = (answers.count(answer) for answer in Agreement)
    lines = [
        "# Error models of the shipped detectors",
        "",
        "An error model stands in for a detector in closed-loop drives: misses, displaced boxes and"
        " ghosts are drawn as the detector was seen to make them (`avsec drive --error-model NAME`,"
        ' or `perception={"name": "error_model", "model": NAME}`). Each was fitted to procedural'
        " drives of connected vehicles, judging assets, and is held here against other drives. The"
        f" margins were set beforehand: {100 * FOUND_MARGIN:g} points of found objects, and"
        f" {GHOST_MARGIN:g} ghosts a frame. A range of distance agrees where both differences, with"
        " their 95 % intervals over drives, lie within the margins; it differs where one lies"
        " outside; where one reaches beyond or nothing is there, these drives cannot tell."
        f" Of {len(answers)} ranges, **{agree} agree, {differ} differ, and of {unknown} these"
        " drives cannot tell**.",
        "",
        "## What they were fitted to",
        "",
        *markdown_table(
            [*_FITTED, "drives held against"],
            [_fitted_row(model) for model in models],
        ),
        "",
        "## Held against drives that they were not fitted to",
        "",
        *markdown_table(
            _CHECKED,
            [row for model in models for row in _check_rows(model)],
        ),
        "",
    ]
    return "\n".join(lines)


def _fitted_row(model: CheckedModel) -> list[str]:
    return [
        f"`{model.name}`",
        model.attack["name"] if isinstance(model.attack, Mapping) else "none",
        str(model.drives),
        str(model.frames),
        str(model.objects),
        number(100 * model.found / model.objects, 1),
        number(model.ghosts / model.frames, 2),
        UNKNOWN if model.check_drives is None else str(model.check_drives),
    ]


def _check_rows(model: CheckedModel) -> list[list[str]]:
    return [
        [
            f"`{model.name}`",
            f"{each.near:g} to {each.far:g}",
            str(each.objects),
            _percent(each.found, each.found_interval),
            _percent(each.found_expected),
            f"{number(each.ghosts, 2)} ± {number(each.ghosts_error, 2)}",
            number(each.ghosts_expected, 2),
            f"**{each.answer}**" if each.answer == Agreement.DIFFERS else str(each.answer),
        ]
        for each in model.checks
    ]


def _percent(share: float | None, interval: Sequence[float] | None = None) -> str:
    if share is None:
        return UNKNOWN
    text = number(100 * share, 1)
    if interval is None:
        return text
    low, high = (number(100 * bound, 1) for bound in interval)
    return f"{text} [{low}, {high}]"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    return page_of_result(
        arguments,
        CheckedModels,
        error_models_page,
        maker="fit",
        what=__doc__,
        remedy=_COMMAND,
    )


if __name__ == "__main__":
    sys.exit(main())
