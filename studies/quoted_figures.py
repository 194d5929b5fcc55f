"""Every figure in README and the documentation has a source.

A figure is a number in digits.  Results stand in blocks that are made from the JSON of
studies/results (`docs_pages`); what else has digits is listed in quoted_figures.toml by page and by
what it is: a figure of the thesis or of others, a setting, or a unit of the text.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from avsec_gym.storage.text_files import read_text
from studies.generated_blocks import without_blocks
from studies.study import ROOT

LIST = Path(__file__).with_name("quoted_figures.toml")
LONGEST = 120
"""Characters of a passage: what is longer would hide a figure that is added to it."""

_NUMBER = re.compile(r"(?<![\w.])\.?\d[\d,]*(?:\.\d+)?(?:e-?\d+)?(?!\w)")
_MARKUP = (
    re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL),  # Commands and code, which tests run.
    re.compile(r"<!--.*?-->", re.DOTALL),
    re.compile(r"`[^`]*`"),
    re.compile(r"(?<=\])\([^)]*\)"),  # Where links lead.
    re.compile(r"^\d\. ", re.MULTILINE),  # Numbered lists.
)
_OF_THE_TEXT = (
    # Parts of the thesis: chapter 3, tables 3.1 and 3.2, figures 3.5 to 3.10.
    re.compile(
        r"\b(?:chapter|section|table|figure|equation|algorithm|lemma)s?\s+\d[\d.]*[ab]?"
        r"(?:(?:,| to| and|, and)\s+\d[\d.]*[ab]?)*",
        re.IGNORECASE,
    ),
    re.compile(r"\b(?:19|20)\d\d\b(?![.,]\d)"),  # Years of papers and of KITTI's benchmarks.
    re.compile(r"\b\d{6}(?:_\d+)?\b"),  # Ids of frames.
    re.compile(r"95\s+%\s+(?:bootstrap\s+)?(?:interval|confidence)"),
)
"""What is no figure wherever it stands."""


class Source(Enum):
    """Where a figure that is no result comes from."""

    THESIS = "thesis"
    OTHERS = "others"
    """A paper, a data set, a device or a program of others."""
    SETTING = "setting"
    """What the code is set to, or a command asks for."""
    UNIT = "unit"
    """A number of the text: versions, names and numbers of things, counts within the sentence."""


@dataclass(frozen=True)
class QuotedFigure:
    """A number in a page.

    Args:
        line: The number of its line, from 1.
        text: Its digits.
        start: Where it begins in the page's text.
    """

    line: int
    text: str
    start: int


@dataclass(frozen=True)
class Passage:
    """Words of a page whose figures have a source other than a result.

    Args:
        source: The source.
        text: The words; line breaks count as spaces.
    """

    source: Source
    text: str

    def spans(self, page: str) -> list[tuple[int, int]]:
        """Where the words stand in a page."""
        words = r"\s+".join(re.escape(word) for word in self.text.split())
        return [found.span() for found in re.finditer(rf"(?<!\w){words}(?!\w)", page)]


def quoted_pages(root: Path = ROOT) -> list[str]:
    """README and all pages of the documentation, as paths below the root."""
    pages = [root / "README.md", *sorted((root / "docs").rglob("*.md"))]
    return [page.relative_to(root).as_posix() for page in pages]


def read_passages(path: Path = LIST) -> dict[str, list[Passage]]:
    """Page -> its passages.

    Raises:
        ValueError: A source is none of `Source`.
    """
    return {
        page: [Passage(Source(source), text) for source, texts in kinds.items() for text in texts]
        for page, kinds in tomllib.loads(read_text(path)).items()
    }


def figures(page: str) -> list[QuotedFigure]:
    """The figures of a page's text.

    Blocks that are made from results are no text, nor are code, links, and what is a number of the
    text wherever it stands: parts of the thesis, years, ids of frames, 95 % of an interval.

    Args:
        page: The page.

    Example:
        >>> [figure.text for figure in figures("Of 1,200 cases (table 3.1) 4.5 % are `n = 3`.")]
        ['1,200', '4.5']
    """
    text = page
    for pattern in (*_MARKUP, *_OF_THE_TEXT):
        text = pattern.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)
    return [
        QuotedFigure(text.count("\n", 0, found.start()) + 1, found[0].rstrip(","), found.start())
        for found in _NUMBER.finditer(text)
    ]


def without_source(page: str, passages: Sequence[Passage]) -> list[QuotedFigure]:
    """The figures of a page that no passage accounts for.

    Args:
        page: The page, with its blocks.
        passages: Its passages.
    """
    text = without_blocks(page)
    spans = [span for passage in passages for span in passage.spans(text)]
    return [
        figure
        for figure in figures(text)
        if not any(start <= figure.start < end for start, end in spans)
    ]


def needless(page: str, passages: Sequence[Passage]) -> list[Passage]:
    """Passages that the page does not have, or in which no figure stands.

    Args:
        page: The page, with its blocks.
        passages: Its passages.
    """
    text = without_blocks(page)
    found = figures(text)
    return [
        passage
        for passage in passages
        if not any(
            start <= figure.start < end for start, end in passage.spans(text) for figure in found
        )
    ]


def all_without_source(passages: Mapping[str, Sequence[Passage]], root: Path = ROOT) -> list[str]:
    """``page:line: figure`` of every figure without a source, in all pages.

    Args:
        passages: Page -> its passages.
        root: Root of the checkout.
    """
    return [
        f"{page}:{figure.line}: {figure.text}"
        for page in quoted_pages(root)
        for figure in without_source(read_text(root / page), passages.get(page, ()))
    ]
