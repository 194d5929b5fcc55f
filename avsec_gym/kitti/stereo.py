"""KITTI's stereo benchmarks of 2012 and 2015 where the user has them: pairs with true disparity."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from avsec_gym.errors import DataError
from avsec_gym.frame import LazyImages, SensorFrame
from avsec_gym.kitti.map_files import Disparity, read_disparity
from avsec_gym.kitti.sensor_files import ImageFile
from avsec_gym.rig import kitti_rig
from avsec_gym.storage.regular_files import is_file, is_folder

Truth = Literal["occ", "noc"]
"""``occ``: all pixels with truth; ``noc``: those that both cameras see (not occluded)."""

_PAIR = re.compile(r"([0-9]{6}_10)\.png")


@dataclass(frozen=True)
class StereoLayout:
    """How a benchmark names its folders.

    Args:
        name: What the benchmark is called.
        left: The folder of the left colour images.
        right: The folder of the right ones.
        truth: The folder of the true disparities, by `Truth`.
    """

    name: str
    left: str
    right: str
    truth: dict[Truth, str]

    @property
    def folders(self) -> tuple[str, ...]:
        """All of them."""
        return self.left, self.right, *self.truth.values()


LAYOUTS = (
    StereoLayout("stereo 2012", "colored_0", "colored_1", {"occ": "disp_occ", "noc": "disp_noc"}),
    StereoLayout("stereo 2015", "image_2", "image_3", {"occ": "disp_occ_0", "noc": "disp_noc_0"}),
)


class KittiStereo:
    """The official layouts: ``training/`` with ``colored_0`` (2012) or ``disp_occ_0`` (2015)...

    Args:
        root: The folder that holds ``training/``, or a half such as ``training`` itself.

    Raises:
        DataError: Nothing of the layouts is there.
    """

    def __init__(self, root: str | Path) -> None:
        self.root = Path(root)
        for folder in (self.root / "training", self.root / "testing", self.root):
            found = stereo_layout(folder)
            if found is not None:
                self.folder, self.layout = folder, found
                return
        raise DataError(
            "Nothing of the KITTI stereo layouts is here."
            if is_folder(self.root)
            else "There is no such folder.",
            path=self.root,
            remedy="Name the folder that holds training/ with colored_0/ and disp_occ/ (2012), or "
            "with image_2/ and disp_occ_0/ (2015).",
        )

    def ids(self, having: Sequence[str] = ()) -> list[str]:
        """The pairs with a left image, such as ``000000_10``, sorted.

        Args:
            having: Folders such as ``disp_occ_0``; pairs without a file in one are left out.
        """
        found = pair_ids(self.folder / self.layout.left)
        for name in having:
            there = set(pair_ids(self.folder / name))
            found = [id for id in found if id in there]
        return found

    def frame(self, id: str) -> SensorFrame:
        """The pair as cameras 2 and 3, loaded on demand.

        Disparities need no calibration, and that of KITTI's usual rig stands in: depths in metres
        that are computed by it are off by as much as the day's own calibration differs.

        Raises:
            DataError: An image lacks.
        """
        images = {}
        for camera, kind in ((2, self.layout.left), (3, self.layout.right)):
            images[camera] = ImageFile(self._file(kind, id))
        calibration = kitti_rig().calibration
        return SensorFrame(id, calibration, LazyImages(images), origin=self.folder)

    def disparity(self, id: str, truth: Truth = "occ") -> Disparity:
        """True disparities of the left image; see `read_disparity`.

        Raises:
            DataError: The file lacks (the testing half has none) or is broken.
        """
        return read_disparity(self._file(self.layout.truth[truth], id))

    def _file(self, kind: str, id: str) -> Path:
        path = self.folder / kind / f"{id}.png"
        if not is_file(path):
            raise DataError(
                f"Pair {id} has no file in {kind}/.",
                path=path,
                remedy=f"Put the {kind} files of KITTI {self.layout.name} there.",
            )
        return path


def stereo_layout(folder: Path) -> StereoLayout | None:
    """The layout of a half of a benchmark, known by folders that no other benchmark has."""
    for layout in LAYOUTS:
        own = (*layout.truth.values(), *(name for name in (layout.left,) if name != "image_2"))
        if any(is_folder(folder / name) for name in own):
            return layout
    # The testing half of 2015 has the object benchmark's folders, but its pairs end in _10.
    return LAYOUTS[1] if pair_ids(folder / LAYOUTS[1].left) else None


def pair_ids(folder: Path) -> list[str]:
    """Sorted ids of the first images (``_10``) in a folder; of none where there is no folder."""
    if not is_folder(folder):
        return []
    return sorted(m[1] for path in folder.iterdir() if (m := _PAIR.fullmatch(path.name)))
