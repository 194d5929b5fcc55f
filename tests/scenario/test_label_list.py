"""Lists of images with labels, as the authors of the scenarios and our own suites write them."""

from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.label_list import ROAD_TYPES, read_label_list


def test_labels_by_image_without_its_suffix(tmp_path: Path) -> None:
    path = tmp_path / "list.csv"
    path.write_text("img_name,label\n000107.png,1\n000001_0d,0\n\n")
    assert read_label_list(path) == {"000107": 1, "000001_0d": 0}
    assert ROAD_TYPES[1] is RoadType.STREET


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "list.csv:1: The first line is not"),
        ("000107.png,1\n", "list.csv:1: The first line is not"),
        ("img_name,label\n000107.png\n", "list.csv:2: '000107.png' is no image with a label"),
        ("img_name,label\n000107.png,1\n000108.png,2\n", "list.csv:3: '000108.png,2'"),
    ],
)
def test_a_broken_list_names_file_and_line(text: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "list.csv"
    path.write_text(text)
    with pytest.raises(DataError) as caught:
        read_label_list(path)
    assert said in str(caught.value)
