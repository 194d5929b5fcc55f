"""Tests of the code in a source."""

from __future__ import annotations

from avsec_gym.storage.source_code import code_of

SOURCE = '''"""What it is for."""

HALF = 0.5
"""Of a whole."""


def halved(value: float) -> float:
    """A half of it."""
    return HALF * value  # Exact.
'''


def test_comments_docstrings_and_layout_do_not_count() -> None:
    plain = "HALF=0.5\ndef halved(\n    value: float\n) -> float:\n    return HALF*value\n"
    assert code_of(SOURCE) == code_of(plain)


def test_code_counts() -> None:
    assert code_of(SOURCE) != code_of(SOURCE.replace("0.5", "0.6"))
    # A string that is a value is code.
    assert code_of("NAME = 'one'") != code_of("NAME = 'two'")
