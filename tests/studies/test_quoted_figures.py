"""README and the documentation have no figure without a source."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from studies.quoted_figures import (
    LONGEST,
    Passage,
    Source,
    all_without_source,
    figures,
    needless,
    quoted_pages,
    read_passages,
    without_source,
)
from studies.study import ROOT

PAGE = """# A page of 2020

Windows of 8 s are cut; the car drives 15 m on
straight lanes.

<!-- made: rates -->

| attacker | 42.3 % |

<!-- /made -->

1. `limit=7` of [80](https://example.org/90) is 6.5 % (figures 3.5 to 3.10, 95 % intervals).

```
python a.py --limit 12
```
"""


def test_every_figure_has_a_source() -> None:
    lacking = all_without_source(read_passages())
    assert not lacking, (
        "show results in a block of studies/docs_pages.py, or list a figure that is no result in"
        f" studies/quoted_figures.toml: {lacking}"
    )


def test_the_list_names_what_pages_have() -> None:
    listed = read_passages()
    assert set(listed) <= set(quoted_pages())
    assert {"README.md", "docs/connected.md", "docs/start/student.md"} <= set(quoted_pages())
    for page, passages in listed.items():
        assert needless((ROOT / page).read_text(), passages) == [], page
        for passage in passages:
            # Digits alone, or a whole paragraph, would cover anything.
            assert re.search(r"[A-Za-z]", passage.text), passage
            assert len(passage.text) <= LONGEST, passage


def test_what_counts_as_a_figure() -> None:
    found = [(figure.line, figure.text) for figure in figures(PAGE)]
    assert found == [(3, "8"), (3, "15"), (8, "42.3"), (12, "80"), (12, "6.5")]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("AUC .985, 1,200 of them, to 1e-6", [".985", "1,200", "1e-6"]),
        ("DSGN 2D, S_0, YOLOv3, 000107, KITTI 2015", []),
        ("algorithms 1 and 2 of section 3.2.4, chapter 5", []),
        ("2,015 of 95 % in 3.11.2", ["2,015", "95", "3.11"]),
    ],
)
def test_numbers_of_the_text_are_none(text: str, found: list[str]) -> None:
    assert [figure.text for figure in figures(text)] == found


def test_a_figure_needs_a_passage_of_its_own_words() -> None:
    passages = [Passage(Source.SETTING, "of 8 s are"), Passage(Source.SETTING, "15 m on straight")]
    others = [Passage(Source.OTHERS, "[80](https"), Passage(Source.THESIS, "is 6.5 %")]
    assert without_source(PAGE, [*passages, *others]) == []
    assert [each.text for each in without_source(PAGE, passages)] == ["80", "6.5"]
    # A result that takes the place of a setting, and one that is put beside it, are found.
    changed = PAGE.replace("of 8 s", "of 9 s")
    assert [each.text for each in without_source(changed, [*passages, *others])] == ["9"]
    added = PAGE.replace("straight lanes.", "straight lanes, in 17 % of them.")
    assert [each.text for each in without_source(added, [*passages, *others])] == ["17"]
    assert needless(changed, passages) == passages[:1]
    assert needless(PAGE, [Passage(Source.UNIT, "are cut")]) != []


def test_the_list_says_where_figures_come_from(tmp_path: Path) -> None:
    file = tmp_path / "list.toml"
    file.write_text('["README.md"]\nthesis = ["600 of"]\nunit = ["in 3 ways"]\n')
    assert read_passages(file) == {
        "README.md": [Passage(Source.THESIS, "600 of"), Passage(Source.UNIT, "in 3 ways")]
    }
    file.write_text('["README.md"]\nresult = ["42 %"]\n')
    with pytest.raises(ValueError, match="result"):
        read_passages(file)
