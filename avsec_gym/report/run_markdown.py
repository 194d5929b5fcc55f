"""A run's main tables in Markdown, for a repository."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.drawing.page_table import Table, bounds, number
from avsec_gym.experiments.chapter3.defence.in_words import defence_sentences
from avsec_gym.experiments.chapter3.defence.tables import tables_of_defence
from avsec_gym.experiments.chapter3.identification.in_words import (
    five_sentences,
    validation_sentences,
)
from avsec_gym.experiments.chapter3.identification.tables import tables_of_validation
from avsec_gym.experiments.chapter3.identification.tables_of_five_sensors import tables_of_five
from avsec_gym.experiments.chapter3.localisation.in_words import localisation_sentences
from avsec_gym.experiments.chapter3.localisation.tables import tables_of_localisation
from avsec_gym.experiments.chapter3.objects.in_words import optical_sentences
from avsec_gym.experiments.chapter3.objects.tables import tables_of_optical_attacks
from avsec_gym.experiments.chapter5.section.tables_beyond import (
    control_table,
    loss_table,
    other_table,
    patch_effect_table,
    rounding_table,
    seen_table,
    time_table,
    trend_table,
)
from avsec_gym.experiments.chapter5.section.tables_of_thesis import tables_of_thesis
from avsec_gym.experiments.chapter5.section.tables_why import (
    ghost_table,
    pyramid_table,
    spread_table,
)
from avsec_gym.report.markdown_table import markdown_table
from avsec_gym.report.run_remarks import facts, inputs, remarks

_LEFT_OUT = ("machine", "scenarios")
"""They name places of one machine."""


def markdown_page(
    report: Mapping[str, Any], command: str = "avsec report RUN --markdown FILE"
) -> str:
    """The answer, the tables, and what the run was.

    Args:
        report: As `avsec_gym.report.run_report.run_report` makes it.
        command: That made it.
    """
    lines = [f"# {report['question']}"]
    if told := remarks(report):
        lines += ["", *(f"> {remark}" for remark in told)]
    lines += _answer(report)
    lines += [
        "",
        f"Made by `{command}`. Intervals in brackets hold 95 %; *italics*: the thesis.",
        "",
    ]
    for table in _tables(report):
        lines += [f"## {table.title}", "", *_table(table), ""]
        lines += [table.note, ""] if table.note else []
    known = [(term, text) for term, text in facts(report) if term not in _LEFT_OUT]
    known += [(name, f"`{digest[:16]}`") for name, digest in inputs(report)]
    lines += [
        "## The run",
        "",
        *markdown_table(["fact", "value"], [list(fact) for fact in known]),
        "",
    ]
    return "\n".join(lines)


def _answer(report: Mapping[str, Any]) -> list[str]:
    said = validation_sentences(report["validation"]) if report.get("validation") else []
    said += five_sentences(report)
    said += [*optical_sentences(report), *localisation_sentences(report)]
    if said := [*said, *defence_sentences(report)]:
        return ["", *(f"- {sentence}" for sentence in said)]
    if "answer" not in report:
        return []
    if report["answer"]["kind"] == "nothing":
        return ["", f"{report['scenarios']:,} scenarios."]
    answer, both = report["answer"], report["decoupling"]["rank_correlation"]["both"]
    lines = [
        "",
        f"**{answer['word']}** {answer['sentence']} {report['scenarios']:,} scenarios.",
        "",
    ]
    for one in answer["detectors"]:
        lines.append(f"- **{one['name']}**: {one['evidence']}. {' '.join(one['took'])}")
    if both["rho"] is not None:
        rho, interval = number(both["rho"], digits=2), bounds(both["interval"], digits=2)
        lines.append(f"- Both together: ρ = {rho} {interval} over {both['attacks']} attacks.")
    return lines


def _tables(report: Mapping[str, Any]) -> list[Table]:
    tables = tables_of_thesis(report)
    if "decoupling" in report:
        tables = [
            loss_table([row for row in report["decoupling"]["attacks"] if not row["whole_levels"]]),
            seen_table(report["seen"]),
            *tables,
            patch_effect_table(report["patch_effects"]),
            ghost_table(report["ghosts"]),
            pyramid_table(report["pyramid"]),
            control_table(report["controls"]),
            trend_table(report["trends"]),
            rounding_table(report["rounding"]),
        ]
    tables += tables_of_validation(report["validation"]) if report.get("validation") else []
    tables += tables_of_five(report)
    tables += tables_of_optical_attacks(report)
    tables += tables_of_localisation(report)
    tables += tables_of_defence(report)
    tables += [spread_table(report["spread"])] if report["spread"] else []
    tables += [other_table(report["other"])] if report["other"] else []
    tables += [time_table(report)]
    return [table for table in tables if table.rows]


def _table(table: Table) -> list[str]:
    """Headings above headings become part of those below."""
    over = [text for text, span in table.groups for _ in range(span)] or [""] * len(table.columns)
    columns = [
        f"{above}, {text}" if above and text else above or text
        for above, text in zip(over, table.columns, strict=True)
    ]
    rows = []
    for row in table.rows:
        rows.append([cell.plain.replace("|", "\\|") for cell in row])
    return markdown_table(columns, rows)
