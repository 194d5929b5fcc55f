"""Every reader of the package, given what is no file: it refuses at once, and names the place.

The readers and their sound files are those of the fuzz (`benchmarks/fuzz`), which has one for each
kind of file that users give.
"""

from __future__ import annotations

import shutil
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random
from types import FrameType
from typing import NamedTuple, TypedDict

import pytest

from avsec_gym.errors import DataError
from avsec_gym.perception.training.curves import Curves
from avsec_gym.storage.json_lines import JsonLines
from avsec_gym.storage.regular_files import append_line

FUZZ = Path(__file__).parents[2] / "benchmarks" / "fuzz"
sys.path.append(str(FUZZ))
from kinds import KINDS, Kind  # noqa: E402
from reader import read  # noqa: E402
from replace_file import REPLACEMENTS  # noqa: E402


class Row(TypedDict):
    id: str


PATIENCE = 60
"""Seconds; a reader that waits for a pipe waits for ever."""
NO_FILES = ("folder", "pipe", "device")


@pytest.fixture(autouse=True)
def _alarm() -> Iterator[None]:
    def ring(_: int, __: FrameType | None) -> None:
        raise TimeoutError("it waits")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(PATIENCE)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


class Sound(NamedTuple):
    """A folder with the sound files of a kind."""

    kind: Kind
    folder: Path


@pytest.fixture(scope="module", params=KINDS.values(), ids=KINDS.keys())
def sound(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Sound:
    """Made once for all tests of the kind."""
    folder = tmp_path_factory.mktemp("sound")
    request.param.make(folder)
    return Sound(request.param, folder)


def test_a_sound_file_of_each_kind_is_read(sound: Sound, tmp_path: Path) -> None:
    """Otherwise the fuzz, which begins with it, ends there."""
    signal.alarm(10 * PATIENCE)  # With imports, and kernels that are compiled on the way.
    folder = Path(shutil.copytree(sound.folder, tmp_path / "copy"))
    assert read(sound.kind, folder) == {"outcome": "read", "detail": ""}


def test_readers_refuse_what_is_no_file(sound: Sound, tmp_path: Path) -> None:
    kind = sound.kind
    for name in NO_FILES:
        signal.alarm(PATIENCE)
        folder = tmp_path / name
        shutil.copytree(sound.folder, folder)
        REPLACEMENTS[name](folder / kind.file, Random(0))
        with pytest.raises(DataError) as caught:
            kind.read(folder)
        message = str(caught.value)
        assert folder.name in message or Path(kind.file).stem in message


APPENDERS = {
    "lines": lambda path: append_line(path, "{}"),
    "rows": lambda path: JsonLines(path, Row).add({"id": "a"}),
    "curves": lambda path: Curves(path.parent).add(1, "losses", {}),
}


@pytest.mark.parametrize("append", APPENDERS.values(), ids=APPENDERS.keys())
@pytest.mark.parametrize("replacement", ["folder", "pipe", "device"])
def test_lines_are_added_to_files_only(
    tmp_path: Path, append: Callable[[Path], None], replacement: str
) -> None:
    path = tmp_path / "curves.jsonl"
    path.write_text("")
    REPLACEMENTS[replacement](path, Random(0))
    with pytest.raises(DataError, match="not a file"):
        append(path)


def test_rows_are_not_added_to_a_pipe_that_took_the_file_s_place(tmp_path: Path) -> None:
    lines, curves = JsonLines(tmp_path / "rows.jsonl", Row), Curves(tmp_path)
    for name in ("rows.jsonl", "curves.jsonl"):
        REPLACEMENTS["pipe"](tmp_path / name, Random(0))
    with pytest.raises(DataError, match="named pipe"):
        lines.add({"id": "a"})
    with pytest.raises(DataError, match="named pipe"):
        curves.add(1, "losses", {})
