"""Blocks of a page hold what is made, and nothing else of it changes."""

from __future__ import annotations

import pytest

from avsec_gym.errors import DataError
from studies.generated_blocks import block_names, with_blocks, without_blocks
from studies.index import with_remark

PAGE = """# Page

Before 1.

<!-- made: first one -->
<!-- /made -->

Between.

<!-- made: second -->

| old |

<!-- /made -->
After 2.
"""


def test_blocks_are_filled_and_filled_again() -> None:
    assert block_names(PAGE) == ["first one", "second"]
    filled = with_blocks(PAGE, {"first one": ["a", "b"], "second": ["| c |"]})
    assert "<!-- made: first one -->\n\na\nb\n\n<!-- /made -->\n\nBetween." in filled
    assert "old" not in filled
    assert with_blocks(filled, {"first one": ["a", "b"], "second": ["| c |"]}) == filled
    assert filled.startswith("# Page\n\nBefore 1.")
    assert filled.endswith("<!-- /made -->\nAfter 2.\n")


def test_what_is_not_made_is_left_line_by_line() -> None:
    left = without_blocks(PAGE).splitlines()
    assert len(left) == len(PAGE.splitlines())
    assert [line for line in left if line] == ["# Page", "Before 1.", "Between.", "After 2."]
    remarked = with_remark(PAGE, "*Stale: 7 of 9 files, 2026-11-28.*")
    assert without_blocks(remarked).splitlines() == ["# Page", *[""] * 4, *left[1:]]


@pytest.mark.parametrize("blocks", [{"second": []}, {"first one": [], "second": [], "third": []}])
def test_other_blocks_than_the_page_has_are_refused(blocks: dict[str, list[str]]) -> None:
    with pytest.raises(DataError, match="second"):
        with_blocks(PAGE, blocks)
