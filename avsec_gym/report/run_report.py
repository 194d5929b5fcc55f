"""The report of a run: facts of the run itself, and what each experiment finds in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

from avsec_gym.errors import ConfigurationError
from avsec_gym.report.run_facts import OtherRates, RunFacts, other_rates, run_facts
from avsec_gym.runs.catalogue import attribute, experiment, importable_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Answer, Findings, FindingsMaker, ReportRequest, Section

_OTHER, _RUN = "other", "run"
"""Sections of the report itself."""


@dataclass(frozen=True)
class RunReport:
    """What pages, texts and JSON are made of.

    Args:
        facts: Facts of the run itself.
        findings: What each experiment finds, in the order of the catalogue, experiments of others
            last.
        other: Rates under settings that no experiment reports.
    """

    facts: RunFacts
    findings: Sequence[Findings] = ()
    other: Sequence[OtherRates] = ()

    @property
    def data(self) -> dict[str, Any]:
        """All figures, as JSON."""
        data = self.facts.to_json()
        for found in self.findings:
            data |= found.data
        return {**data, _OTHER: [rates.to_json() for rates in self.other]}

    @property
    def sections(self) -> list[Section]:
        """The sections of the page."""
        return [section for found in self.findings for section in found.sections]

    @property
    def sentences(self) -> list[str]:
        """What the run found, section by section."""
        return [sentence for section in self.sections for sentence in section.sentences]

    @property
    def answer(self) -> Answer | None:
        """The answer to the run's question, if an experiment gives one."""
        return next((found.answer for found in self.findings if found.answer), None)

    @property
    def extent(self) -> str:
        """What the figures are of, such as ``600 scenarios``; empty if no experiment states it."""
        return next((found.extent for found in self.findings if found.extent), "")

    @property
    def problems(self) -> list[str]:
        """Which pictures could not be made, and why."""
        return [problem for found in self.findings for problem in found.problems]

    @property
    def attack_names(self) -> dict[str, str]:
        """What attacks are called, in the order of tables."""
        return _attack_names(self.findings)


def run_report(run: RunFolder, request: ReportRequest = ReportRequest()) -> RunReport:
    """All figures of a run, finished or not.

    Every experiment of the catalogue is asked, since experiments share cells: what it finds follows
    from the results, not from what the run was asked for. Experiments of others are asked where
    they are installed by an entry point, or the request names them. An experiment that stands alone
    is asked in a run of its own, and nothing else is then.

    Args:
        run: The run.
        request: The pictures that were asked for, and all other wishes.

    Raises:
        ConfigurationError: Two experiments give figures, or sections, the same name.
        DataError: Data that a section needs are not where they were.
    """
    known, problems = importable_experiments()
    asked = [*known, *map(experiment, request.experiments)]
    every = [each.section for each in asked]
    (first, *others) = run.manifest["experiments"]
    asked = [each for each in asked if each.alone and [each.name, *others] == [first]] or [
        each for each in asked if not each.alone
    ]
    places = list(dict.fromkeys(each.section for each in asked if each.section))
    findings = [_findings(place, run, request) for place in places]
    findings += [Findings(remarks=[f"{problem}."]) for problem in problems]
    findings += [Findings(remarks=remarks) for remarks in [_unasked(run, every)] if remarks]
    _check_names(findings)
    own = next(iter(run.manifest["experiments"].values()))["question"]
    question = next((found.question for found in findings if found.question), own)
    facts = run_facts(run, question, list(_attack_names(findings)))
    reported = {setting for found in findings for setting in found.settings}
    return RunReport(facts, findings, other_rates(run, reported))


def _attack_names(findings: Sequence[Findings]) -> dict[str, str]:
    return {key: words for found in findings for key, words in found.attack_names.items()}


def _unasked(run: RunFolder, places: Sequence[str]) -> list[str]:
    """Sections that only the run's manifest names: their code may be a stranger's, so it waits."""
    named = {entry.get("section") or "" for entry in run.manifest["experiments"].values()}
    return [
        f"A section is missing: the run names {place}, of another package. Name its experiment to"
        " have it shown: --experiments MY_PACKAGE.MY_MODULE:MY_EXPERIMENT."
        for place in sorted(named - {"", *places})
    ]


def _findings(place: str, run: RunFolder, request: ReportRequest) -> Findings:
    try:
        make: FindingsMaker = attribute(place)
    except ConfigurationError as error:
        return Findings(remarks=[f"A section is missing: {error}."])
    return make(run, request)


def _check_names(findings: Sequence[Findings]) -> None:
    ids = Counter([_OTHER, _RUN, *(section.id for found in findings for section in found.sections)])
    if twice := [name for name, count in ids.items() if count > 1]:
        raise ConfigurationError(f"two sections of the report have the id {twice[0]}")
    own = [_OTHER, *(field.name for field in fields(RunFacts))]
    figures = Counter([*own, *(name for found in findings for name in found.data)])
    if twice := [name for name, count in figures.items() if count > 1]:
        raise ConfigurationError(f"two experiments give figures the name {min(twice)}")
