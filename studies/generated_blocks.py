"""Parts of pages that are made: ``<!-- made: NAME -->`` to ``<!-- /made -->``, and the remark."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from avsec_gym.errors import DataError

REMARK_BEGIN, REMARK_END = "<!-- sources -->", "<!-- /sources -->"
REMARK = re.compile(f"\n{REMARK_BEGIN}\n.*?\n{REMARK_END}\n", re.DOTALL)
"""What is said of a page's sources, below its title."""
_BLOCK = re.compile(r"<!-- made: (?P<name>[\w ]+) -->\n(?P<text>.*?)<!-- /made -->", re.DOTALL)


def block_names(page: str) -> list[str]:
    """The names of a page's blocks, in their order."""
    return [found["name"] for found in _BLOCK.finditer(page)]


def with_blocks(page: str, blocks: Mapping[str, Sequence[str]]) -> str:
    r"""A page whose blocks hold these lines.

    Args:
        page: The page.
        blocks: Name -> lines.

    Raises:
        DataError: The page has other blocks than these.

    Example:
        >>> with_blocks("<!-- made: a -->\n<!-- /made -->", {"a": ["text"]})
        '<!-- made: a -->\n\ntext\n\n<!-- /made -->'
    """
    if sorted(block_names(page)) != sorted(blocks):
        raise DataError(
            f"A page has the blocks {block_names(page)}, and these are made: {sorted(blocks)}.",
            remedy="Name the same in the page and in studies/docs_blocks.py.",
        )

    def block(found: re.Match[str]) -> str:
        text = "\n".join(blocks[found["name"]])
        return f"<!-- made: {found['name']} -->\n\n{text}\n\n<!-- /made -->"

    return _BLOCK.sub(block, page)


def without_blocks(page: str) -> str:
    """A page with empty lines in the place of its blocks and its remark."""
    for made in (_BLOCK, REMARK):
        page = made.sub(lambda found: re.sub(r"[^\n]", "", found[0]), page)
    return page
