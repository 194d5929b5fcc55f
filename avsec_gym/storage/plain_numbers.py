"""Numbers as files spell them, which are fewer than those that Python reads."""

from __future__ import annotations


def plain_number(word: str) -> float:
    """The number that a word of a text file spells.

    Python also reads digits of any script and digits that are grouped, ``1_000``: in a file they
    are damage, or of a format that is not meant.

    Args:
        word: Digits of ASCII with a point and an exponent; or nan and inf, which a reader that
            wants finite numbers refuses by their value.

    Raises:
        ValueError: It spells none.

    Example:
        >>> plain_number("7.215e+02")
        721.5
        >>> plain_number("7_21.5")
        Traceback (most recent call last):
        ...
        ValueError: '7_21.5' is no number
    """
    if not word.isascii() or "_" in word:
        raise ValueError(f"{word[:40]!r} is no number")
    return float(word)
