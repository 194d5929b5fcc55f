"""What a study that was stopped has computed so far, kept in the repository until it is finished.

Some studies take longer than one sitting, and the next one may be on another machine.
"""

from __future__ import annotations

import io
import json
import lzma
import re
import tarfile
from collections.abc import Iterator
from lzma import LZMAError
from pathlib import Path

from avsec_gym.console import say
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.regular_files import MAX_FILE_BYTES, is_there, read_bytes
from studies.provenance import changed, sources_of
from studies.study import ROOT, Study

KEPT = ROOT / "studies" / "kept"
MOST_BYTES = 2**23
"""The largest archive."""
_SOURCES = "sources.json"
"""The archive's first file: the sources by which the rest was computed."""
_PICTURES = {".png", ".jpg", ".webp", ".gif", ".bin", ".log"}
"""Files that are made again, or that nothing is computed from."""


def keep(study: Study, runs: Path, kept: Path = KEPT) -> Path:
    """Pack what a study has computed; data sets and pictures, which are made again, are left out.

    Args:
        study: One of the catalogue.
        runs: The folder of runs.
        kept: Where the archive is written.

    Returns:
        The archive.

    Raises:
        ConfigurationError: There is nothing to keep, or more than belongs into a repository.
    """
    files = _files(study, runs)
    if not files:
        raise ConfigurationError(f"{study.name} has computed nothing in {runs} that could be kept.")
    content = io.BytesIO()
    with tarfile.open(fileobj=content, mode="w:xz") as archive:
        _add(archive, _SOURCES, json.dumps(sources_of(study.sources)).encode())
        for file in files:
            _add(archive, file.relative_to(runs).as_posix(), read_bytes(file, most=MAX_FILE_BYTES))
    if content.tell() > MOST_BYTES:
        raise ConfigurationError(
            f"What {study.name} has computed is {content.tell() / 2**20:.0f} MB, packed; at most"
            f" {MOST_BYTES / 2**20:.0f} MB are kept in the repository."
        )
    kept.mkdir(exist_ok=True)
    path = _archive(study, kept)
    write_bytes(path, content.getvalue(), overwrite=True)
    return path


def take_up(study: Study, runs: Path, kept: Path = KEPT) -> bool:
    """Unpack what was kept of a study, if it has nothing in the folder of runs.

    What was computed by other sources stays packed: the study then begins from nothing.

    Args:
        study: One of the catalogue.
        runs: The folder of runs.
        kept: Where the archive may lie.

    Returns:
        Whether something was unpacked.

    Raises:
        DataError: The archive is damaged.
    """
    path = _archive(study, kept)
    if not is_there(path) or _files(study, runs):
        return False
    try:
        content = read_bytes(path, most=MOST_BYTES)
        with tarfile.open(fileobj=io.BytesIO(content), mode="r:xz") as archive:
            sources = archive.extractfile(_SOURCES)
            then = json.loads(sources.read()) if sources else {}
            if others := changed(then, sources_of(study.sources)):
                say(f"{study.name} begins from nothing: {len(others)} sources have changed since"
                    f" {path.name} was kept, {others[0]} first")  # fmt: skip
                return False
        # Read to its end before anything is written.
        with tarfile.open(fileobj=io.BytesIO(lzma.decompress(content))) as archive:
            members = [member for member in archive if member.name != _SOURCES]
            archive.extractall(runs, members, filter="data")
    except (tarfile.TarError, LZMAError, EOFError, OSError, ValueError, KeyError) as error:
        raise DataError(
            f"The archive is damaged: {error}", path=path, remedy="git checkout it, or remove it."
        ) from error
    say(f"{study.name} goes on with what {path.name} has kept: {len(members)} files")
    return True


def forget(study: Study, kept: Path = KEPT) -> None:
    """Remove what was kept of a study, which is finished."""
    _archive(study, kept).unlink(missing_ok=True)


def _archive(study: Study, kept: Path) -> Path:
    return kept / f"{study.name}.tar.xz"


def _files(study: Study, runs: Path) -> list[Path]:
    """What it has computed, in the folders that its steps name and that are named as it is."""
    words = " ".join(word for step in study.steps for word in step.words)
    names = set(re.findall(r"\$runs/(\w+)", words))
    own = [each for each in names if each.startswith(study.name) or study.name.startswith(each)]
    return sorted(file for name in own for file in _computed(runs / name))


def _computed(folder: Path) -> Iterator[Path]:
    """The files of a folder, without pictures and data sets, whose images are in `training`."""
    if not folder.is_dir() or (folder / "training").is_dir():
        return
    for path in folder.iterdir():
        if path.is_dir():
            yield from _computed(path)
        elif path.suffix not in _PICTURES:
            yield path


def _add(archive: tarfile.TarFile, name: str, content: bytes) -> None:
    """The same bytes for the same files: neither times nor users."""
    facts = tarfile.TarInfo(name)
    facts.size = len(content)
    archive.addfile(facts, io.BytesIO(content))
