"""Pairs are found in every layout, and one scene is one scene."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from avsec_gym.errors import DataError
from studies.chapter3.real_pairs.image_pairs import LEFT, RIGHT, image_pairs

DAY = "raw/2011_09_26/2011_09_26_drive_0001_sync"
FILES = {
    "object/training/image_2/000003.png": "object/training/000003",
    "object/training/prev_2/000003_01.png": "object/training/000003",
    "object/training/image_2/000004.png": "object/training/000004",
    "stereo2015/training/image_2/000003_10.png": "stereo2015/training/000003",
    "stereo2015/training/image_2/000003_11.png": "stereo2015/training/000003",
    "stereo2012/training/colored_0/000000_10.png": "stereo2012/training/000000",
    "stereo2012/training/image_0/000000_10.png": "stereo2012/training/000000",
    "tracking/training/image_02/0007/000005.png": "tracking/training/0007",
    "odometry/sequences/04/image_2/000000.png": "odometry/sequences/04/000000",
    f"{DAY}/image_02/data/0000000005.png": DAY,
    f"{DAY}/image_00/data/0000000006.png": DAY,
}
OTHERS = {
    "image_2": "image_3", "prev_2": "prev_3", "colored_0": "colored_1", "image_0": "image_1",
    "image_02": "image_03", "image_00": "image_01",
}  # fmt: skip


def write(path: Path, level: int, width: int = 40) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    assert cv2.imwrite(str(path), np.full((20, width, 3), level, np.uint8))


def right_of(name: str) -> str:
    parts = name.split("/")
    [place] = [number for number, part in enumerate(parts) if part in OTHERS]
    return "/".join([*parts[:place], OTHERS[parts[place]], *parts[place + 1 :]])


def test_all_layouts_are_found_and_scenes_are_told_apart(tmp_path: Path) -> None:
    for number, name in enumerate(FILES):
        write(tmp_path / name, number)
        write(tmp_path / right_of(name), 100 + number)
    # Without a partner these are no pairs.
    write(tmp_path / "object/training/image_2/000009.png", 1)
    write(tmp_path / "object/training/image_3/000010.png", 1)
    found = image_pairs(tmp_path)
    assert {pair.id: pair.scene for pair in found} == {
        name.removesuffix(".png"): scene for name, scene in FILES.items()
    }
    assert [pair.id for pair in found] == sorted(pair.id for pair in found)
    for pair in found:
        number, frame = [*FILES].index(f"{pair.id}.png"), pair.frame()
        assert frame.image(LEFT).max() == number
        assert frame.image(RIGHT).min() == 100 + number


def test_a_single_data_set_is_a_root_too(tmp_path: Path) -> None:
    for name in ("training/image_2/000003_10.png", "training/image_3/000003_10.png"):
        write(tmp_path / name, 3)
    [pair] = image_pairs(tmp_path)
    assert (pair.id, pair.scene) == ("training/image_2/000003_10", "training/000003")


def test_nothing_and_unequal_images_are_errors(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no pair of images"):
        image_pairs(tmp_path)
    write(tmp_path / "image_2/000000.png", 1)
    write(tmp_path / "image_3/000000.png", 1, width=30)
    with pytest.raises(DataError, match="differ in size"):
        image_pairs(tmp_path)[0].frame()


def test_the_pairs_at_hand(shared: Path) -> None:
    found = image_pairs(shared / "kitti")
    assert {pair.scene.partition("/")[0] for pair in found} >= {
        "object", "stereo2012", "stereo2015"
    }  # fmt: skip
    own = [pair for pair in found if pair.scene == "object/training/000274"]
    assert len(own) == 4
