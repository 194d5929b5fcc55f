"""What is said of each study's sources: on its pages, and for all of them in studies/README.md."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from os.path import relpath
from pathlib import Path

from avsec_gym.storage.text_files import read_text
from studies.catalogue import STUDIES, minutes_of_command
from studies.provenance import Record, changed, sources_of
from studies.study import ROOT, Study

README = ROOT / "studies/README.md"

_BEGIN, _END = "<!-- sources -->", "<!-- /sources -->"
_REMARK = re.compile(f"\n{_BEGIN}\n.*?\n{_END}\n", re.DOTALL)
_CURRENT = "Sources: unchanged"
_NAMED = 3
"""So many of the sources that have changed are named."""

_HEAD = """# Studies

What the pages of results stand on: each study answers a question by one command, which writes its
files anew and records its sources. A command that was stopped goes on where its runs are, which lie
in `runs` or in `--runs DIR`; *DIR* is data that cannot be in the repository: `python -m studies
--help` lists them. `python -m studies` lists the studies, `python -m studies check` compares their
sources with those of today and fails where a page calls itself current that is not, and
`python -m studies index` writes the result into this page and into the remark at the top of every
other one. A study that has not been made yet has its row and its command here, and no page.

| study | question | command | takes about | sources |
| --- | --- | --- | --- | --- |
"""


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
        """In a word or two."""
        return {None: "not made yet", True: "stale", False: "current"}[self.stale]


def source_states(records: Mapping[str, Record]) -> dict[str, SourceState]:
    """That of every study; see `source_state`."""
    return {name: source_state(study, records) for name, study in STUDIES.items()}


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
        return SourceState(False, f"{_CURRENT} {since}")
    named = ", ".join([*others[:_NAMED], *(["..."] if len(others) > _NAMED else [])])
    count = f"{len(others)} of {len({*then.values(), *now.values()})} source files have changed"
    return SourceState(True, f"Stale: {count} ({named}) {since}")


def with_remark(page: str, remark: str) -> str:
    """A page that states something of itself below its title, in place of what it stated before."""
    title, end, rest = _REMARK.sub("", page, count=1).partition("\n")
    return f"{title}{end}\n{_BEGIN}\n{remark}\n{_END}\n{rest}"


def without_remark(page: str) -> str:
    """A page as its study writes it."""
    return _REMARK.sub("", page, count=1)


def pages(records: Mapping[str, Record], root: Path = ROOT) -> dict[Path, str]:
    """File -> what has to be in it: the index, and every page with its remark.

    A study that has not been made yet has its row in the index, and no page.

    Args:
        records: Records of all studies.
        root: Root of the checkout.

    Raises:
        DataError: The page of a study that was made is not there.
    """
    index = root / README.relative_to(ROOT)
    written = {index: _HEAD}
    for study in STUDIES.values():
        state = source_state(study, records, root)
        written[index] += f"| {' | '.join(_row(study, state, root))} |\n"
        for name in study.pages:
            if study.name not in records and not (root / name).is_file():
                continue
            all_of_them = f"[all studies]({relpath(index, (root / name).parent)})"
            remark = f"*{state.text}. `{study.command}` makes it anew; {all_of_them}.*"
            written[root / name] = with_remark(read_text(root / name), remark)
    return written


def outdated(written: Mapping[Path, str]) -> list[Path]:
    """Those of the pages that hold something else, or are not there."""
    return [path for path, text in written.items() if not path.is_file() or read_text(path) != text]


def called_current(states: Mapping[str, SourceState], root: Path = ROOT) -> list[str]:
    """Pages that call sources unchanged which are not, and the index where it does, sorted.

    A page that calls itself stale is none of them, whichever changed files it names.

    Args:
        states: Today's state of studies.
        root: Root of the checkout.
    """
    changed_since = [STUDIES[name] for name, state in states.items() if state.stale is not False]
    claims = {}
    for name in (name for study in changed_since for name in study.pages):
        remark = _REMARK.search(_text(root / name))
        claims[name] = remark is not None and _CURRENT in remark[0]
    index = README.relative_to(ROOT).as_posix()
    rows = [row for row in _text(root / index).splitlines() if _CURRENT in row]
    heads = tuple(f"| [{study.name}](" for study in changed_since)
    claims[index] = any(row.startswith(heads) for row in rows)
    return sorted(name for name, is_wrong in claims.items() if is_wrong)


def _text(page: Path) -> str:
    return read_text(page) if page.is_file() else ""


def _row(study: Study, state: SourceState, root: Path) -> Iterable[str]:
    opened = root / study.writes[0]
    link = f"[{study.name}]({relpath(opened, root / README.parent.relative_to(ROOT))})"
    yield link if opened.is_file() else study.name
    yield study.question
    yield f"`{study.command}`"
    yield f"{minutes_of_command(study)} min"
    yield state.text


def _age(record: Record) -> tuple[bool, str]:
    """What was recorded counts as newer than what was not."""
    return record.sources is not None, record.date
