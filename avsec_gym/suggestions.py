"""What a user who wrote an unknown name may have meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

_CLOSE = 0.6
"""Least similarity, as `difflib.SequenceMatcher.ratio` measures it, that is worth a word."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """A question that names the known name nearest to an unknown one.

    Capitals do not count, nor whether words are joined by ``-``, ``_`` or a space.

    Args:
        name: The unknown name.
        known: Names that there are.

    Returns:
        A sentence; empty where nothing is near.

    Example:
        >>> did_you_mean("DSGM", ["dsgn", "pixor"])
        'Did you mean "dsgn"?'
        >>> did_you_mean("yolo", ["dsgn", "pixor"])
        ''
    """
    # The first of several names that read alike stands for them.
    by_reading = {_as_read(known_name): known_name for known_name in reversed(list(known))}
    near = get_close_matches(_as_read(name), list(by_reading), n=1, cutoff=_CLOSE)
    return f'Did you mean "{by_reading[near[0]]}"?' if near else ""


def unknown_name(problem: str, name: str, known: Iterable[str]) -> str:
    """A message about an unknown name: the problem, what it may have meant, what there is.

    Args:
        problem: What is wrong, without a full stop.
        name: The unknown name.
        known: Names that there are.

    Example:
        >>> print(unknown_name("there is no detector dsgm", "dsgm", ["dsgn", "pixor"]))
        there is no detector dsgm. Did you mean "dsgn"? Known: dsgn, pixor
    """
    known = list(known)
    sentences = [f"{problem}.", did_you_mean(name, known), f"Known: {', '.join(known)}"]
    return " ".join(sentence for sentence in sentences if sentence)


def _as_read(name: str) -> str:
    return name.strip().lower().replace("-", "_").replace(" ", "_")
