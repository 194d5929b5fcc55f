"""A run's main tables in Markdown, for a repository."""

from __future__ import annotations

from avsec_gym.drawing.page_table import Table
from avsec_gym.report.markdown_table import markdown_table
from avsec_gym.report.run_remarks import facts, inputs, remarks
from avsec_gym.report.run_report import RunReport
from avsec_gym.report.run_tables import other_table, time_table

_LEFT_OUT = ("machine", "scenarios")
"""They name places of one machine."""


def markdown_page(report: RunReport, command: str = "avsec report RUN --markdown FILE") -> str:
    """The answer, the tables, and what the run was.

    Args:
        report: Facts of the run and the sections of its experiments.
        command: The command that made the text.
    """
    lines = [f"# {report.facts.question}"]
    if remarks_of_run := remarks(report):
        lines += ["", *(f"> {remark}" for remark in remarks_of_run)]
    lines += _answer(report)
    lines += [
        "",
        f"Made by `{command}`. Intervals in brackets hold 95 %; *italics*: the thesis.",
        "",
    ]
    for table in _tables(report):
        lines += [f"## {table.title}", "", *_table(table), ""]
        lines += [table.note, ""] if table.note else []
    known = [(term, text) for term, text in facts(report.facts) if term not in _LEFT_OUT]
    known += [(name, f"`{digest[:16]}`") for name, digest in inputs(report.facts)]
    lines += [
        "## The run",
        "",
        *markdown_table(["fact", "value"], [list(fact) for fact in known]),
        "",
    ]
    return "\n".join(lines)


def _answer(report: RunReport) -> list[str]:
    lines = []
    if answer := report.answer:
        extent = f" {report.extent}." if report.extent else ""
        lines += ["", f"**{answer.word}** {answer.sentence}{extent}", ""]
        lines += [
            f"- **{case.name}**: {case.evidence}. {' '.join(case.sentences)}"
            for case in answer.cases
        ]
        lines += [f"- {answer.together}"] if answer.together else []
    if said := report.sentences:
        lines += ["", *(f"- {sentence}" for sentence in said)]
    return lines


def _tables(report: RunReport) -> list[Table]:
    tables = [table for section in report.sections for table in section.tables]
    tables += [
        other_table(report.other),
        time_table(report.facts.timings.attacks, report.attack_names),
    ]
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
