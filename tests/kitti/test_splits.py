from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from avsec_gym.kitti.splits import RawOrigin, read_raw_mapping, read_split


def test_a_split_keeps_its_order(tmp_path: Path) -> None:
    path = tmp_path / "val.txt"
    for content in ("000004\n000001", "000004\n000001\n\n", "000004\r\n000001 \r\n"):
        path.write_bytes(content.encode())
        assert read_split(path) == ["000004", "000001"]
    path.write_text("")
    assert read_split(path) == []


@pytest.mark.parametrize(
    ("content", "line", "message"),
    [
        ("000001\n000002\n000001\n", 3, "stands in line 1"),
        ("000001\n\n000002\n", 2, "''"),
        ("000001\n12\n", 2, "'12'"),
        ("0000000001\n", 1, "six digits"),
        ("000001 1\n", 1, "six digits"),
        ("٠٠٠٠٠١\n", 1, "six digits"),
        ("../../x\n", 1, "six digits"),
    ],
)
def test_a_broken_split_is_named(tmp_path: Path, content: str, line: int, message: str) -> None:
    path = tmp_path / "val.txt"
    path.write_bytes(content.encode())
    with pytest.raises(DataError) as caught:
        read_split(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")
    assert message in str(caught.value)
    assert caught.value.remedy


def mapping(folder: Path, rand: str = "2,1\n", drive: str = "2011_09_26_drive_0005_sync") -> Path:
    (folder / "train_rand.txt").write_text(rand)
    (folder / "train_mapping.txt").write_text(
        f"2011_09_26 {drive} 0000000109\n2011_09_28 2011_09_28_drive_0106_sync 0000000048\n"
    )
    return folder


def test_the_permutation_gives_lines_from_one(tmp_path: Path) -> None:
    origins = read_raw_mapping(mapping(tmp_path))
    assert origins == {
        "000000": RawOrigin("2011_09_28", "0106", 48),
        "000001": RawOrigin("2011_09_26", "0005", 109),
    }
    assert origins["000000"].folder == "2011_09_28/2011_09_28_drive_0106_sync"


@pytest.mark.parametrize("rand", ["2,3\n", "0,1\n", "2,2\n", "2,x\n", "2,-1", "", "2,²"])
def test_no_permutation_is_refused(tmp_path: Path, rand: str) -> None:
    with pytest.raises(DataError, match=r"train_rand\.txt:1: "):
        read_raw_mapping(mapping(tmp_path, rand))


@pytest.mark.parametrize("drive", ["2011_09_27_drive_0005_sync", "drive_5", "a b", ""])
def test_a_broken_mapping_is_named(tmp_path: Path, drive: str) -> None:
    with pytest.raises(DataError, match=r"train_mapping\.txt:1: "):
        read_raw_mapping(mapping(tmp_path, drive=drive))


def test_the_devkits_own_example(shared: Path) -> None:
    origins = read_raw_mapping(shared / "kitti/object/mapping")
    assert len(origins) == 7481
    assert origins["000000"] == RawOrigin("2011_09_28", "0106", 48)


def test_real_splits(shared: Path) -> None:
    sets = shared / "kitti/object/ImageSets"
    train, val = read_split(sets / "train.txt"), read_split(sets / "val.txt")
    assert (len(train), len(val)) == (3712, 3769)
    assert sorted(train + val) == read_split(sets / "trainval.txt")
