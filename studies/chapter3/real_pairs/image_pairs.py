"""Every pair of images below KITTI's root, whichever of its layouts they are in."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.sensor_files import read_image
from avsec_gym.rig import kitti_rig

LEFT, RIGHT = 2, 3
"""What the cameras of a pair are called, whatever their folders are."""
FOLDERS = {
    "image_2": "image_3",
    "image_02": "image_03",
    "prev_2": "prev_3",
    "colored_0": "colored_1",
    "image_0": "image_1",
    "image_00": "image_01",
}
"""Left -> right, in the object, raw, tracking, stereo 2012 and 2015, and odometry layouts.  Where
both grey and coloured images of one frame are there, both are pairs of one scene."""


@dataclass(frozen=True)
class ImagePair:
    """Two images of one instant.

    Args:
        id: Path of the left image below the root, without its ending.
        scene: Pairs of one scene are alike: a drive, or a frame with those shortly before it.
        left: File of the left image.
        right: File of the right image.
    """

    id: str
    scene: str
    left: Path
    right: Path

    def frame(self) -> SensorFrame:
        """Both images, as of KITTI's colour cameras, whose focal length and baseline they share.

        Raises:
            DataError: An image is broken, or the two differ in size.
        """
        images = {LEFT: read_image(self.left), RIGHT: read_image(self.right)}
        if images[LEFT].shape != images[RIGHT].shape:
            raise DataError(
                "The two images of a pair differ in size.",
                path=self.right,
                remedy="Fetch both from one of KITTI's archives.",
            )
        return SensorFrame(self.id, kitti_rig().calibration, images)


def image_pairs(root: Path) -> list[ImagePair]:
    """All pairs below a folder, sorted by their ids.

    Args:
        root: A folder that holds KITTI's data sets, or one of them.

    Raises:
        DataError: There is no pair.
    """
    pairs, root = [], root.resolve()
    for name, other in FOLDERS.items():
        for folder in sorted(root.rglob(name)):
            beside = folder.with_name(other)
            for left in sorted(folder.rglob("*.png")):
                right = beside / left.relative_to(folder)
                if right.is_file():
                    id = left.relative_to(root).with_suffix("").as_posix()
                    pairs.append(ImagePair(id, _scene(left, folder, root), left, right))
    if not pairs:
        raise DataError(
            "There is no pair of images.",
            path=root,
            remedy="Name a folder with image_2 and image_3, or another of KITTI's layouts.",
        )
    return sorted(pairs, key=lambda pair: pair.id)


def _scene(left: Path, folder: Path, root: Path) -> str:
    """The scene that an image belongs to, by its place."""
    data_set = folder.parent.relative_to(root).as_posix()
    if left.parent.name == "data":  # A drive of the raw data.
        return data_set
    if left.parent != folder:  # A sequence of the tracking benchmark.
        return f"{data_set}/{left.parent.name}"
    # 000274 and 000274_01 to 000274_03, 000000_10 and 000000_11.
    return f"{data_set}/{left.stem.partition('_')[0]}"
