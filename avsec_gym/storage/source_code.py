"""What of a source decides what it does: the code, not its comments, docstrings and layout."""

from __future__ import annotations

import io
import tokenize


def code_of(source: str) -> str:
    """A source without comments, docstrings and layout.

    Example:
        >>> code_of("x = 1  # Why.")
        'x=1'
    """
    between = (tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)
    words, begins = [], True
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type in (tokenize.NL, tokenize.COMMENT):
            continue
        if token.type in between:
            begins = True
            continue
        # A string that begins a statement is a docstring, or words behind a constant.
        if not (begins and token.type == tokenize.STRING):
            words.append(token.string)
        begins = False
    return "".join("".join(words).split())
