"""What happens to text: numbers that are none, words too few or too many, lines mixed up."""

from __future__ import annotations

import re
from collections.abc import Callable
from random import Random

from mutate_bytes import Mutator

NUMBERS = (
    "nan", "NaN", "inf", "-inf", "Infinity", "1e400", "-1e400", "1e308", "1e-320", "-0.0", "0",
    "-1", "-4", "1e9", "-1e9", "2147483648", "-9223372036854775809", "1" * 400, "0x10", "1_000",
    "1,5", "1.", ".5", "+3", "--3", "1e", "e5", "\u0663", "\uff11\uff12", "True", "None", "null",
    "", "1 2", "1;DROP TABLE", "%s", "{0}", "\\u0031", "1\u00a0", "½", "10000.5", "361", "-7",
)  # fmt: skip
"""What stands where a number stood."""
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_WORD = re.compile(r"[^\s,<>\"=:]+")
_Edit = Callable[[str, Random], str]


def number(text: str, random: Random) -> str:
    """One number becomes another, or something that is none."""
    return _replace(text, _NUMBER, random.choice(NUMBERS), random)


def several_numbers(text: str, random: Random) -> str:
    """Four of them do."""
    for _ in range(4):
        text = number(text, random)
    return text


def slightly_other_number(text: str, random: Random) -> str:
    """A number of the same kind, with the other sign, ten or a thousand times as large."""
    places = list(_NUMBER.finditer(text))
    if not places:
        return text
    place = random.choice(places)
    value = float(place.group()) * random.choice((-1, 10, 1000, 0.001, -1000, 1e7))
    return text[: place.start()] + f"{value:.10g}" + text[place.end() :]


def word(text: str, random: Random) -> str:
    """A word becomes a strange one."""
    strange = random.choice(
        (
            "",
            "Tram Car",
            "../../etc",
            "\x00",
            "ä" * 300,
            "👾",
            "\u202e",
            "=1+1",
            "A" * 5000,
            "-",
            ".",
        )
    )
    return _replace(text, _WORD, strange, random)


def missing_word(text: str, random: Random) -> str:
    """A column too few."""
    return _replace(text, re.compile(r"[^\s,]+"), "", random)


def doubled_word(text: str, random: Random) -> str:
    """A column too many."""
    places = list(_WORD.finditer(text))
    if not places:
        return text
    place = random.choice(places)
    return text[: place.end()] + " " + text[place.start() :]


def lines(text: str, random: Random) -> str:
    """Lines are lost, doubled, exchanged or joined."""
    rows = text.splitlines(keepends=True)
    if not rows:
        return text
    at = random.randrange(len(rows))
    match random.randrange(5):
        case 0:
            del rows[at]
        case 1:
            rows.insert(at, rows[at])
        case 2:
            random.shuffle(rows)
        case 3:
            rows[at] = rows[at].rstrip("\r\n")
        case 4:
            rows[at:] = [random.choice(("\n" * 50, "#\n", "\x0c\n", " \t \n", "garbage\n"))]
    return "".join(rows)


def white_space(text: str, random: Random) -> str:
    """Other line ends, other spaces, a byte order mark."""
    match random.randrange(7):
        case 0:
            return text.replace("\n", "\r\n")
        case 1:
            return text.replace("\n", "\r")
        case 2:
            return text.replace(" ", "\t")
        case 3:
            return text.replace(" ", "\u00a0")
        case 4:
            return text.replace("\n", random.choice("\u2028\x85\x0b\x1c"))
        case 5:
            return "\ufeff" + text
        case _:
            return text.replace("\n", "")


def long_line(text: str, random: Random) -> str:
    """A line of a megabyte."""
    place = random.randint(0, len(text))
    return text[:place] + random.choice(("9", " ", "x", "(", "[")) * 1_000_000 + text[place:]


def encoding(text: str, random: Random) -> bytes:
    """In another one than UTF-8."""
    return text.encode(
        random.choice(("utf-16", "utf-32", "utf-16-be", "utf-7", "cp037")), "replace"
    )


def _on_text(edit: Callable[[str, Random], str | bytes]) -> Mutator:
    def mutate(content: bytes, random: Random) -> bytes:
        changed = edit(content.decode("utf-8", "surrogateescape"), random)
        if isinstance(changed, bytes):
            return changed
        return changed.encode("utf-8", "surrogateescape")

    return mutate


TEXT: dict[str, Mutator] = {
    mutator.__name__: _on_text(mutator)
    for mutator in (
        number,
        several_numbers,
        slightly_other_number,
        word,
        missing_word,
        doubled_word,
        lines,
        white_space,
        long_line,
        encoding,
    )
}


def _replace(text: str, pattern: re.Pattern[str], new: str, random: Random) -> str:
    places = list(pattern.finditer(text))
    if not places:
        return text
    place = random.choice(places)
    return text[: place.start()] + new + text[place.end() :]
