"""Keeps the words out that the project has left behind, in names, comments and prose alike.

``python docs/words.py`` lists every line that holds one; `make lint` runs it.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterable, Iterator
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROOMS = (
    "avsec_gym", "benchmarks", "docs", "examples", "studies", "tests",
    ".github", "leaderboard", "CHANGELOG.md", "CONTRIBUTING.md", "README.md",
)  # fmt: skip
"""Folders and files whose words are those of the field."""
READ = (".py", ".md", ".toml", ".js", ".css", ".html", ".j2", ".ipynb", ".yml")
"""How names of files that are read end: sources, prose, pages' parts and notebooks."""
WORDS = {
    "moment": "frame (one rig) or instant (several vehicles)",
    "moments": "frames or instants",
    "verdict": "sensor status, or collision check",
    "verdicts": "sensor statuses, or collision checks",
    "suspect": "compromised sensor",
    "suspects": "compromised sensors",
    "notice": "detect, or alarm",
    "noticed": "detected",
    "notices": "detects",
    "noticing": "detecting",
    "unnoticed": "undetected",
    "nobody": "no attack, or what the sentence is about",
    "somebody": "the attacker, or a user",
    "somebodys": "what it belongs to",
    "anybody": "the attacker, or a user",
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
NAMES = {
    "stage": "built scene, or what it holds",
    "shot": "posed scene, or attempt",
    "shots": "posed scenes, or attempts",
    "desk": "worker",
}
"""Parts of modules', classes' and functions' names: in sentences, these words have other uses."""
SUBJECTLESS = (
    "At", "Before", "Beyond", "By", "From", "In", "It", "Likewise", "Likewise,", "Of", "On", "That",
    "To", "Whose", "With", "Without",
)  # fmt: skip
"""Words that no text below a field or a constant begins with, and no summary of a public function,
method or class; tests are left their shorthand."""
NO_ARGUMENT = (
    *SUBJECTLESS, "Above", "As", "Below", "Beside", "Called", "Decides", "For", "Gets", "Gives",
    "Go", "Handed", "Holds", "Instead", "Keeps", "Makes", "Over", "Picks", "Proposes", "Reads",
    "Refuse", "See", "Takes", "Undo", "Yields",
)  # fmt: skip
"""Words that no description of an argument begins with."""
DOCUMENTED = ("avsec_gym/", "studies/")
"""Folders whose docstrings are read for a subject."""
# Their bytes are the fingerprint of rendered data sets: a better docstring would make all of them
# anew.
FINGERPRINTED = (
    "avsec_gym/world/", "avsec_gym/kitti/", "avsec_gym/boxes.py", "avsec_gym/frame.py",
    "avsec_gym/geometry.py", "avsec_gym/rig.py", "avsec_gym/road_type.py",
)  # fmt: skip
"""Sources whose docstrings are not read."""
RECORDED = ("closed_loop", "drives", "kitti", "world")
"""Folders in whose code a class `Drive` is KITTI's recording, or a closed-loop run."""
STAGES = ("avsec_gym/perception/", "tests/perception/")
"""Folders of networks, which have stages."""

ALLOWED = {
    ("avsec_gym/world/models/plants/trees.py", "stakes"): "wooden ones that hold a young tree",
    ("avsec_gym/world/models/furniture/pavement.py", "notice"): "a board on a letter box",
    ("avsec_gym/validation/fitted_on.py", "moments"): "a key in files of earlier releases",
    ("avsec_gym/world/export/frame_files.py", "told"): "a name within; the world's code is data's",
    ("CHANGELOG.md", "moments"): "an old name, beside the new one",
    ("CHANGELOG.md", "verdicts"): "an old name, beside the new one",
    ("CHANGELOG.md", "knowing"): "the old name of an experiment",
    ("CHANGELOG.md", "noticed"): "the old key of an info, beside the new one",
    ("tests/runs/test_renamed.py", "knowing"): "the old name of an experiment",
    ("tests/runs/test_renamed_rows.py", "knowing"): "the old name of an experiment",
}
"""Uses that are right as they are: file and word, and why."""
LISTS = ("avsec_gym/runs/renamed.py", "docs/words.py", "tests/test_words.py")
"""Files that list old words."""

_ENTRY = re.compile(r"\*{0,2}\w+(?:, \*{0,2}\w+)*: (\S.*)")
"""An argument, and what it is."""
_UNIT = re.compile(r"(?:Bytes|Degrees|Metres|Pixels|Radians|Seconds|m/s2?|rad/s)[.,;]")
"""A description that begins with a unit alone; ``Metres ahead of the car`` begins with a noun."""
_QUESTION = re.compile(r"\w+ (?:how|which|what)\b")
"""An indirect question may begin with a preposition: ``In which regions ...``."""
_DEFINED = re.compile(r"\b(?:class|def) +(\w+)")
_APART = re.compile(r"(?<=[a-z])(?=[A-Z])")
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
    parted = _APART.sub("_", text)
    for number, line in enumerate(parted.splitlines(), start=1):
        for match in _WORD.finditer(line):
            yield number, match[1].lower()


def names_of(path: str, text: str) -> Iterator[tuple[int, str, str]]:
    """Names in Python code that are not to be given: line, name, and what stands in its place.

    Args:
        path: The file's place in the project; its own name counts as one of line 1.
        text: Its text.

    Example:
        >>> [(line, name) for line, name, _ in names_of("a/b.py", "class LaserShot: ...")]
        [(1, 'LaserShot')]
    """
    given = [(1, Path(path).stem)]
    for number, line in enumerate(text.splitlines(), start=1):
        given += [(number, match[1]) for match in _DEFINED.finditer(line)]
    for number, name in given:
        for part in _APART.sub("_", name).lower().split("_"):
            if part in NAMES and not (part == "stage" and path.startswith(STAGES)):
                yield number, name, NAMES[part]
        if name in ("Drive", "Drives") and not set(Path(path).parts) & set(RECORDED):
            yield number, name, "episode, or the setting and the row of a closed-loop run"


def without_subject(text: str, *, docstrings: bool = True) -> Iterator[tuple[int, str]]:
    """Descriptions that begin with a preposition or a verb, as if the name before them were read.

    Args:
        text: Python code.
        docstrings: Whether arguments and summaries in docstrings are read, beside what stands below
            fields and constants.

    Returns:
        The line of each, and its first word.
    """
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.ClassDef, ast.Module)):
            yield from _fields_without_subject(node.body)
        if docstrings and isinstance(node, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            match node.body[0]:
                case ast.Expr(value=ast.Constant(value=str(docstring))) as first:
                    if not node.name.startswith("_"):
                        yield from _summary_without_subject(docstring, first.lineno)
                    yield from _arguments_without_subject(docstring, first.lineno)


def _fields_without_subject(body: list[ast.stmt]) -> Iterator[tuple[int, str]]:
    for field, below in pairwise(body):
        match below:
            case ast.Expr(value=ast.Constant(value=str(text))):
                first = text.split()[0] if text.split() else ""
                if isinstance(field, (ast.Assign, ast.AnnAssign)) and first in SUBJECTLESS:
                    yield below.lineno, first


def _summary_without_subject(docstring: str, line: int) -> Iterator[tuple[int, str]]:
    first = docstring.split()[0] if docstring.split() else ""
    if first in SUBJECTLESS and not _QUESTION.match(docstring):
        yield line, first


def _arguments_without_subject(docstring: str, line: int) -> Iterator[tuple[int, str]]:
    inside = None
    for number, text in enumerate(docstring.splitlines(), start=line):
        indent = len(text) - len(text.lstrip())
        if text.strip() == "Args:":
            inside = indent
        elif inside is not None and text.strip() and indent <= inside:
            # What follows the arguments: Returns, Raises, Example.
            inside = None
        elif inside is not None and indent == inside + 4 and (entry := _ENTRY.match(text.strip())):
            first = entry[1].split()[0]
            if first in NO_ARGUMENT or _UNIT.match(entry[1]):
                yield number, first


def complaints(files: Iterable[Path]) -> list[str]:
    """A line for each word of some files that is not to be used, its file and line first."""
    result = []
    for file in files:
        path = file.relative_to(ROOT).as_posix()
        known = WORDS if path.startswith("tests/") else WORDS | PUBLIC_WORDS
        text = file.read_text(encoding="utf-8")
        for number, word in found(text):
            if word in known and (path, word) not in ALLOWED:
                result.append(f"{path}:{number}: {word!r}: say {known[word]}")
        if file.suffix == ".py":
            for number, name, instead in names_of(path, text):
                result.append(f"{path}:{number}: the name {name!r}: say {instead}")
            read = path.startswith(DOCUMENTED) and not path.startswith(FINGERPRINTED)
            described = [] if path.startswith("tests/") else without_subject(text, docstrings=read)
            for number, first in described:
                result.append(f"{path}:{number}: begins with {first!r}: say the noun first")
    return result


def files_of_rooms() -> list[Path]:
    """The sources and pages of all rooms, without those that list the words."""
    files: list[Path] = []
    for room in (ROOT / room for room in ROOMS):
        inside = room.rglob("*") if room.is_dir() else [room]
        files += [file for file in inside if file.suffix in READ]
    return sorted(file for file in files if file.relative_to(ROOT).as_posix() not in LISTS)


def main() -> int:
    """The command; its exit code: 1 if there is such a word."""
    lines = complaints(files_of_rooms())
    for line in lines:
        print(line)
    return bool(lines)


if __name__ == "__main__":
    sys.exit(main())
