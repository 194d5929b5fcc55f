"""What an experiment shows of a run: sections of its report, before they are HTML, text or JSON.

An experiment names the function that makes them, so that who does its cells loads no plots::

    def findings(run: RunFolder, request: ReportRequest) -> Findings:
        shares = shares_of(run)
        if not shares:
            return Findings()
        section = Section("coins", "Are they fair?", [in_words(shares)], [table_of(shares)])
        return Findings([section], {"coins": shares})

    COINS = Experiment("coins", "Are coins fair?", "", cells, section="my_package.coins:findings")
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from avsec_gym.drawing.page_figure import Figure
from avsec_gym.drawing.page_table import Table
from avsec_gym.progress import Progress, no_progress

if TYPE_CHECKING:
    from avsec_gym.runs.run_folder import RunFolder

SectionPart = Table | Figure | Markup
"""A table, a figure, or HTML that an experiment makes itself."""


def _no_progress(what: str) -> AbstractContextManager[Progress]:
    return nullcontext(no_progress)


@dataclass(frozen=True)
class ReportRequest:
    """What a report is asked for, beyond the figures of a run.

    Args:
        pictures: The most pictures for which a part of the run is repeated; 0: none.
        looked_at: How many of the judged frames, the first ones, were looked at while a method was
            made; see `avsec report --looked-at`.
        keeps_pictures: Whether pictures also become files in the run's folder.
        experiments: Experiments of other packages whose sections are wanted, as
            ``"my_package.my_module:MY_EXPERIMENT"``. A run's folder may come from anywhere: nothing
            that only its manifest names is imported.
        progress: Function that shows how far a job of a given name is.
    """

    pictures: int = 0
    looked_at: int = 0
    keeps_pictures: bool = False
    experiments: Sequence[str] = ()
    progress: Callable[[str], AbstractContextManager[Progress]] = _no_progress


@dataclass(frozen=True)
class AnswerOn:
    """An answer for one case, such as one detector.

    Args:
        name: The case.
        evidence: What the answer rests on, in short.
        sentences: What was measured.
    """

    name: str
    evidence: str
    sentences: Sequence[str]


@dataclass(frozen=True)
class Answer:
    """The answer to the run's question, which stands above all sections.

    Args:
        word: The answer, in a word or two.
        sentence: The answer as a sentence.
        cases: The answer case by case.
        figure: What shows it; its title is not used.
        together: One sentence on all cases together, for the text.
    """

    word: str
    sentence: str
    cases: Sequence[AnswerOn]
    figure: Figure
    together: str = ""


@dataclass(frozen=True)
class Section:
    """A section of a report.

    Args:
        id: Anchor on the page: letters, digits and ``-``, of no other section.
        title: Heading of the section.
        sentences: What the run found in words, which also stands at the head of the text and on the
            console.
        parts: Tables and figures, in the order of the page.
        link: A shorter heading for the page's list of sections; the title, if empty.
        context: What else stands below the heading.
        text_tables: The tables of the text, if others than those among `parts`.
    """

    id: str
    title: str
    sentences: Sequence[str] = ()
    parts: Sequence[SectionPart] = ()
    link: str = ""
    context: str = ""
    text_tables: Sequence[Table] | None = None

    @property
    def tables(self) -> list[Table]:
        """The tables of the text."""
        if self.text_tables is not None:
            return [*self.text_tables]
        return [part for part in self.parts if isinstance(part, Table)]


@dataclass(frozen=True)
class Findings:
    """All that an experiment shows of a run.

    Args:
        sections: The sections in the order of the page.
        data: The figures behind them as JSON, by names that no other experiment has.
        settings: The names of the settings whose rates are reported here; rates of settings that no
            experiment reports stand in a table of their own.
        attack_names: What values of the cells' argument ``attack`` are called, in the order of
            tables.
        answer: The answer to the run's question.
        question: The page's heading, if it is answered here.
        extent: What the figures are of, such as ``600 scenarios``.
        remarks: What must be known before anything else.
        problems: Pictures that could not be made, and why.
        style: CSS that the sections need beside the page's own.
        script: JavaScript that they need, likewise.
    """

    sections: Sequence[Section] = ()
    data: Mapping[str, Any] = field(default_factory=dict)
    settings: Collection[str] = ()
    attack_names: Mapping[str, str] = field(default_factory=dict)
    answer: Answer | None = None
    question: str = ""
    extent: str = ""
    remarks: Sequence[str] = ()
    problems: Sequence[str] = ()
    style: str = ""
    script: str = ""


FindingsMaker = Callable[["RunFolder", ReportRequest], Findings]
"""Makes the findings of an experiment: all that a run's results allow, whoever asked for them."""
