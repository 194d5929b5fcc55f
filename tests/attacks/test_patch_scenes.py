"""The frames of a folder that a patch is trained on, and how they are described."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from avsec_gym.attacks.patch_scenes import KittiScenes
from avsec_gym.errors import DataError
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.world.export.manifest import new_manifest, write_manifest

IDS = ("000000", "000002")


@pytest.fixture
def data(tmp_path: Path) -> KittiObject:
    """Two frames that have everything, and one between them without labels."""
    for folder, suffix in (
        ("image_2", "png"),
        ("image_3", "png"),
        ("calib", "txt"),
        ("label_2", "txt"),
    ):
        (tmp_path / folder).mkdir()
        for id in ("000000", "000001", "000002"):
            if (folder, id) != ("label_2", "000001"):
                (tmp_path / folder / f"{id}.{suffix}").touch()
    (tmp_path / "ImageSets").mkdir()
    (tmp_path / "ImageSets" / "half.txt").write_text("000001\n")
    return KittiObject(tmp_path)


def test_frames_that_lack_a_file_are_left_out(data: KittiObject) -> None:
    assert KittiScenes.of_split(data).ids == IDS
    assert KittiScenes.of_split(data, limit=1).ids == IDS[:1]


def test_the_error_names_the_split_if_there_is_one(data: KittiObject) -> None:
    with pytest.raises(DataError, match="No frame of the split 'half' has a file"):
        KittiScenes.of_split(data, "half")
    for path in (data.root / "image_3").iterdir():
        path.unlink()
    with pytest.raises(DataError, match="No frame has a file"):
        KittiScenes.of_split(data)


def test_the_description_identifies_the_frames_and_a_data_set_that_has_a_manifest(
    data: KittiObject,
) -> None:
    scenes = KittiScenes.of_split(data)
    without = scenes.description()
    assert without == {
        "name": data.root.name,
        "fingerprint": None,
        "frames": 2,
        "ids_sha256": hashlib.sha256("\n".join(IDS).encode()).hexdigest(),
    }
    write_manifest(data.root, new_manifest({}) | {"fingerprint": "abc"})
    assert scenes.description() == without | {"fingerprint": "abc"}
