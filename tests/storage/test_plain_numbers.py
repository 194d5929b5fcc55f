"""Every reader of text refuses numbers that only Python reads.

The readers and their sound files are those of the fuzz (`benchmarks/fuzz`).
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from avsec_gym.storage.plain_numbers import plain_number

FUZZ = Path(__file__).parents[2] / "benchmarks" / "fuzz"
sys.path.append(str(FUZZ))
from kinds import KINDS, Kind  # noqa: E402
from mutate_text import TEXT  # noqa: E402

# JSON has a grammar of its own, and YAML itself groups digits; both are read by libraries.
TEXTS = [
    kind
    for kind in KINDS.values()
    if set(TEXT) <= set(kind.mutators) and Path(kind.file).suffix in (".txt", ".xml", ".pcd")
]
_WHOLE_WORD = re.compile(r"(?<![^\s>:,\[])-?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?(?![^\s<,\]}])")


def _grouped(word: str) -> str:
    return re.sub(r"([0-9])([0-9])", r"\1_\2", word, count=1)


def _foreign(word: str) -> str:
    return word.translate({ord("0") + digit: 0x0660 + digit for digit in range(10)})


@pytest.mark.parametrize("change", [_grouped, _foreign])
@pytest.mark.parametrize("kind", TEXTS, ids=lambda kind: kind.name)
def test_digits_are_neither_grouped_nor_foreign(
    kind: Kind, change: Callable[[str], str], tmp_path: Path
) -> None:
    kind.make(tmp_path)
    path = tmp_path / kind.file
    text = path.read_text()
    changed = _WHOLE_WORD.sub(lambda match: change(match[0]), text)
    if changed == text:
        pytest.skip("its numbers have a digit each")
    path.write_text(changed)
    with pytest.raises(DataError):
        kind.read(tmp_path)


@pytest.mark.parametrize("word", ["1_0", "١", "1\u20090", "0x10", "", " ", "1,5", "one"])
def test_other_words_are_no_numbers(word: str) -> None:
    with pytest.raises(ValueError):
        plain_number(word)
    assert plain_number("-1.5E-3") == -0.0015


def test_whole_numbers_are_asked_for_as_int_reads_them() -> None:
    """``"²".isdigit()`` is true, and ``int("²")`` an error."""
    package = Path(__file__).parents[2] / "avsec_gym"
    asking = [path.name for path in package.rglob("*.py") if "isdigit" in path.read_text("utf-8")]
    assert asking == []
