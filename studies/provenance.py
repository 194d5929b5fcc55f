"""Which sources a study was made from, and whether they have changed since.

The sources of a study are the files that it begins with, what these name by ``"module:attribute"``,
as an experiment does with its section, and all that either import.  Whatever else is named by
strings, such as detectors, and weights are listed by the study.
"""

from __future__ import annotations

import ast
import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path

from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.regular_files import MAX_FILE_BYTES, read_bytes, read_text
from avsec_gym.storage.source_code import code_of
from avsec_gym.storage.text_files import write_text
from studies.study import RESULTS, ROOT

RECORDS = ROOT / RESULTS / "sources.json"
_PLACE = re.compile(r"\w+(\.\w+)+:\w+")
"""The pattern of ``"module:attribute"``."""


@dataclass(frozen=True)
class Record:
    """When a study was made, and from what."""

    date: str
    """Such as 2026-11-23."""
    commit: str = ""
    """Commit of those that were made before sources were recorded, the commit that brought the
    figures."""
    version: str = ""
    command: str = ""
    seconds: int = 0
    """What this time took, which may have gone on with what an earlier one had left."""
    sources: Mapping[str, str] | None = None
    """Digest to path, one for each file; None: not recorded."""


def sources_of(begin: Iterable[str], root: Path = ROOT) -> dict[str, str]:
    """The state of all sources that some files and folders bring in.

    Args:
        begin: Paths below the root, of Python sources, other files, or folders of them.
        root: Root of the checkout.

    Returns:
        Eight digits -> path.  They change with the path and with the code, not with comments,
        docstrings and layout; of other files with any byte.
    """
    first = {file for name in begin for file in _files(root / name)}
    todo = list(first)
    found: dict[Path, str] = {}
    while todo:
        file = todo.pop()
        if file in found:
            continue
        path = file.relative_to(root).as_posix()
        if file.suffix == ".py":
            text = read_text(file)
            found[file] = _digest_of_code(path, text)
            todo += _imported(file, text, root, by_string=file in first)
        else:
            found[file] = _digest(path, read_bytes(file, most=MAX_FILE_BYTES))
    return {digest: file.relative_to(root).as_posix() for file, digest in found.items()}


def changed(recorded: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Paths of sources that were changed, added or taken away, sorted."""
    paths = {**recorded, **now}
    return sorted({paths[digest] for digest in recorded.keys() ^ now.keys()})


def read_records(path: Path = RECORDS) -> dict[str, Record]:
    """Study -> its record.

    Raises:
        DataError: The file is not there, or damaged.
    """
    content = read_json_object(path, remedy="git checkout it.")
    files, records = content["files"], {}
    for name, facts in content["studies"].items():
        digests = facts.pop("sources", None)
        sources = None if digests is None else {path: files[path] for path in digests.split()}
        records[name] = Record(**facts, sources=sources)
    return records


def write_records(records: Mapping[str, Record], path: Path = RECORDS) -> None:
    """Write them; what several studies have in common stands there once."""
    files: dict[str, str] = {}
    studies = {}
    for name, record in sorted(records.items()):
        facts = {
            key: value for key, value in asdict(replace(record, sources=None)).items() if value
        }
        if record.sources is not None:
            facts["sources"] = " ".join(sorted(record.sources))
            files |= record.sources
        studies[name] = facts
    content = {"studies": studies, "files": dict(sorted(files.items(), key=lambda one: one[::-1]))}
    write_text(path, json.dumps(content, indent=1) + "\n", overwrite=True)


def _files(place: Path) -> Iterator[Path]:
    if place.is_dir():
        yield from (
            file for file in place.rglob("*") if file.is_file() and "__pycache__" not in file.parts
        )
    else:
        yield place


@cache
def _digest_of_code(path: str, text: str) -> str:
    return _digest(path, code_of(text).encode())


def _digest(path: str, content: bytes) -> str:
    return hashlib.sha256(path.encode() + b"\0" + content).hexdigest()[:8]


@cache
def _imported(file: Path, text: str, root: Path, *, by_string: bool) -> tuple[Path, ...]:
    """The files below the root that a source imports, wherever in it, or names by strings.

    A package's ``__init__`` counts where something is taken from it, not where it is passed by.
    """
    names = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names += [f"{node.module}.{alias.name}" for alias in node.names]
        elif by_string and isinstance(node, ast.Constant) and _PLACE.fullmatch(str(node.value)):
            names.append(str(node.value).replace(":", "."))
    # A script imports its neighbours by their bare names.
    bases = (root, file.parent)
    found = {_module(base, name) for name in names for base in bases}
    return tuple(value for value in found if value is not None)


def _module(base: Path, name: str) -> Path | None:
    """The source of ``package.module``, or of ``package.module.attribute``."""
    place = base / name.replace(".", "/")
    for file in (place.with_suffix(".py"), place / "__init__.py"):
        if file.is_file():
            return file
    return _module(base, name.rpartition(".")[0]) if "." in name else None
