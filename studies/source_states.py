"""Whether a study's sources are those of today."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from studies.catalogue import STUDIES
from studies.provenance import Record, changed, sources_of
from studies.study import ROOT, Study

CURRENT = "Sources: unchanged"
"""The remark on a study whose sources are those of today begins so."""
_NAMED = 3
"""So many of the sources that have changed are named."""


@dataclass(frozen=True)
class SourceState:
    """Whether a study's sources are those that it was made from."""

    stale: bool | None
    """True also where its sources were not recorded: they were restructured since, and the world
    that most studies render has a second edition.  None: not made yet."""
    text: str
    """The remark in a sentence."""

    @property
    def word(self) -> str:
        """The state in a word or two."""
        return {None: "not made yet", True: "stale", False: "current"}[self.stale]


def source_states(records: Mapping[str, Record], root: Path = ROOT) -> dict[str, SourceState]:
    """The state of every study; see `source_state`."""
    return {name: source_state(study, records, root) for name, study in STUDIES.items()}


def source_state(study: Study, records: Mapping[str, Record], root: Path = ROOT) -> SourceState:
    """Compare the sources of a study, and of those that its page shows, with what was recorded.

    Args:
        study: One of the catalogue.
        records: Records of all studies.
        root: Root of the checkout.
    """
    parts = [study, *(STUDIES[name] for name in study.shows)]
    if any(part.name not in records for part in parts):
        return SourceState(None, "Not made yet")
    made = min((records[part.name] for part in parts), key=_age)
    if made.sources is None:
        return SourceState(
            True,
            "Stale: made before its sources were recorded"
            f" (commit {made.commit}, {made.date}), and many have changed since",
        )
    then = {k: v for part in parts for k, v in (records[part.name].sources or {}).items()}
    now = sources_of((name for part in parts for name in part.sources), root)
    since = f"since it was made, {made.date} (avsec-gym {made.version})"
    if not (others := changed(then, now)):
        return SourceState(False, f"{CURRENT} {since}")
    named = ", ".join([*others[:_NAMED], *(["..."] if len(others) > _NAMED else [])])
    count = f"{len(others)} of {len({*then.values(), *now.values()})} source files have changed"
    return SourceState(True, f"Stale: {count} ({named}) {since}")


def _age(record: Record) -> tuple[bool, str]:
    """What was recorded counts as newer than what was not."""
    return record.sources is not None, record.date
