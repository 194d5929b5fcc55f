"""Keeps the words out that the project has left behind, in names, comments and prose alike.

``python docs/words.py`` lists every line that holds one; `make lint` runs it.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROOMS = (
    "avsec_gym", "benchmarks", "docs", "examples", "studies", "tests",
    "CONTRIBUTING.md", "README.md",
)  # fmt: skip
"""Folders and files whose words are those of the field."""
WORDS = {
    "moment": "frame (one rig) or instant (several vehicles)",
    "moments": "frames or instants",
    "verdict": "sensor status, or collision check",
    "verdicts": "sensor statuses, or collision checks",
    "suspect": "compromised sensor",
    "suspects": "compromised sensors",
    "noticed": "detected",
    "notices": "detects",
    "unnoticed": "undetected",
    "nobody": "no attack, or what the sentence is about",
    "somebody": "the attacker, or a user",
    "everybody": "every vehicle",
    "mended": "corrected, or repaired",
    "honesty": "calibration",
    "stakes": "headroom",
    "knowing": "adaptive",
    "for one in": "the noun of what the loop goes through",
}
"""A word, and what stands in its place."""
PUBLIC_WORDS = {"told": "reported, or known", "says": "reports, states, or the thing itself"}
"""Words that only tests may have, whose names and sentences no user reads."""

ALLOWED = {
    ("avsec_gym/world/models/plants/trees.py", "stakes"): "wooden ones that hold a young tree",
    ("avsec_gym/validation/fitted_on.py", "moments"): "a key in files of earlier releases",
    ("avsec_gym/world/export/frame_files.py", "told"): "a name within; the world's code is data's",
    ("tests/runs/test_renamed.py", "knowing"): "the old name of an experiment",
    ("tests/runs/test_renamed_rows.py", "knowing"): "the old name of an experiment",
}
"""Uses that are right as they are: file and word, and why."""
LISTS = ("avsec_gym/runs/renamed.py", "docs/words.py", "tests/test_words.py")
"""Files that list old words."""

_WORD = re.compile(
    # Parts of names count as words: `test_noticed`, `_Moment`; of `knowingly` nothing does.
    r"(?<![a-z])(" + "|".join(WORDS | PUBLIC_WORDS) + r")(?![a-z])",
    re.IGNORECASE,
)


def found(text: str) -> Iterator[tuple[int, str]]:
    """The words of a text that are not to be used, each with the number of its line.

    Example:
        >>> list(found("Each _moment of a DRIVE, and momentum."))
        [(1, 'moment')]
    """
    # Names that join words by capitals are parted first: RepairedMoments.
    parted = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", text)
    for number, line in enumerate(parted.splitlines(), start=1):
        for match in _WORD.finditer(line):
            yield number, match[1].lower()


def complaints(files: Iterable[Path]) -> list[str]:
    """A line for each word of some files that is not to be used, its file and line first."""
    result = []
    for file in files:
        path = file.relative_to(ROOT).as_posix()
        known = WORDS if path.startswith("tests/") else WORDS | PUBLIC_WORDS
        for number, word in found(file.read_text(encoding="utf-8")):
            if word in known and (path, word) not in ALLOWED:
                result.append(f"{path}:{number}: {word!r}: say {known[word]}")
    return result


def files_of_rooms() -> list[Path]:
    """The sources and pages of all rooms, without those that list the words."""
    files: list[Path] = []
    for room in (ROOT / room for room in ROOMS):
        inside = room.rglob("*") if room.is_dir() else [room]
        files += [file for file in inside if file.suffix in (".py", ".md", ".toml")]
    return sorted(file for file in files if file.relative_to(ROOT).as_posix() not in LISTS)


def main() -> int:
    """The command; its exit code: 1 if there is such a word."""
    lines = complaints(files_of_rooms())
    for line in lines:
        print(line)
    return bool(lines)


if __name__ == "__main__":
    sys.exit(main())
