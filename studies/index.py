"""Remarks on each study's sources: on its pages, and for all of them in studies/README.md."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os.path import relpath
from pathlib import Path

from avsec_gym.storage.text_files import read_text
from studies.catalogue import STUDIES, minutes_of_command
from studies.generated_blocks import REMARK, REMARK_BEGIN, REMARK_END
from studies.source_states import CURRENT, SourceState
from studies.study import ROOT, Study

README = ROOT / "studies/README.md"

_HEAD = """# Studies

What the pages of results stand on: each study answers a question by one command, which writes its
files anew and records its sources. A command that was stopped goes on where its runs are, which lie
in `runs` or in `--runs DIR`; `python -m studies keep NAME` packs what it has computed into
`studies/kept`, and any machine with the same sources goes on from there. *DIR* is data that cannot
be in the repository: `python -m studies --help` lists them. `python -m studies` lists the studies,
`python -m studies check` compares their sources with those of today and fails where a page calls
itself current that is not, and `python -m studies index` writes the result into this page and into
the remark at the top of every other one. A study that has not been made yet has its row and its
command here, and no page.

| study | question | command | takes about | sources |
| --- | --- | --- | --- | --- |
"""


def with_remark(page: str, remark: str) -> str:
    """A page that states something of itself below its title, in place of what it stated before."""
    title, end, rest = REMARK.sub("", page, count=1).partition("\n")
    return f"{title}{end}\n{REMARK_BEGIN}\n{remark}\n{REMARK_END}\n{rest}"


def without_remark(page: str) -> str:
    """A page as its study writes it."""
    return REMARK.sub("", page, count=1)


def pages(states: Mapping[str, SourceState], root: Path = ROOT) -> dict[Path, str]:
    """File -> what has to be in it: the index, and every page of a study with its remark.

    A study that has not been made yet has its row in the index, and no page.

    Args:
        states: Today's state of studies.
        root: Root of the checkout.

    Raises:
        DataError: The page of a study that was made is not there.
    """
    index = root / README.relative_to(ROOT)
    written = {index: _HEAD}
    for study in (STUDIES[name] for name in states):
        state = states[study.name]
        written[index] += f"| {' | '.join(_row(study, state, root))} |\n"
        for name in study.pages:
            if state.stale is None and not (root / name).is_file():
                continue
            all_of_them = f"[all studies]({relpath(index, (root / name).parent)})"
            remark = f"*{state.text}. `{study.command}` makes it anew; {all_of_them}.*"
            written[root / name] = with_remark(read_text(root / name), remark)
    return written


def outdated(written: Mapping[Path, str]) -> list[Path]:
    """The pages that hold something else, or are not there."""
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
        remark = REMARK.search(_text(root / name))
        claims[name] = remark is not None and CURRENT in remark[0]
    index = README.relative_to(ROOT).as_posix()
    rows = [row for row in _text(root / index).splitlines() if CURRENT in row]
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
