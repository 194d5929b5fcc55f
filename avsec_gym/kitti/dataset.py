"""The KITTI object benchmark where the user has it, complete or in part."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.frame import Calibration, LazyImages, SensorFrame
from avsec_gym.kitti.calibration import read_calibration
from avsec_gym.kitti.label_folders import check_id, frame_ids
from avsec_gym.kitti.labels import read_labels
from avsec_gym.kitti.sensor_files import ImageFile, ScanFile
from avsec_gym.kitti.splits import RawOrigin, read_raw_mapping, read_split
from avsec_gym.sensor_system import LIDAR, Sensor
from avsec_gym.storage.regular_files import is_file, is_folder

SUFFIXES = {"label_2": ".txt", "calib": ".txt", "velodyne": ".bin"}
"""Folders of the layout besides ``image_N`` and ``prev_N``, whose files are ``.png``."""

_IMAGES = re.compile(r"(image|prev)_([0-9]|[1-9][0-9])")


class KittiObject:
    """The official layout: ``training/`` with ``label_2``, ``calib``, ``image_2``, ``velodyne``...

    Any part may be absent until it is asked for.

    Args:
        root: The folder that holds ``training/``, or a folder such as ``training`` itself.

    Raises:
        DataError: Nothing of the layout is there.
    """

    def __init__(self, root: str | Path) -> None:
        self.root = Path(root)
        for folder in (self.root / "training", self.root):
            if layout_folders(folder):
                self.folder = folder
                return
        raise DataError(
            "Nothing of the KITTI object layout is here."
            if is_folder(self.root)
            else "There is no such folder.",
            path=self.root,
            remedy="Name the folder that holds training/ with label_2/, calib/, image_2/ and so "
            "on; `avsec data check` lists what a folder holds.",
        )

    def ids(self, split: str | None = None, having: Sequence[str] = ()) -> list[str]:
        """Frames, such as ``000107``.

        Args:
            split: Name of a split, such as ``val``: the frames of ``ImageSets/val.txt`` in its
                order; all that have any file, sorted, if None.
            having: Folders such as ``image_3``; frames without a file in one of them are left out.

        Raises:
            DataError: The split, or a folder of `having`, is not there, or no frame at all.
        """
        if split is not None:
            path = self._find(f"ImageSets/{split}.txt", "the splits, ImageSets/")
            result = read_split(path)
        else:
            every = [
                frame_ids(self.folder / name, file_suffix(name))
                for name in layout_folders(self.folder)
                if not name.startswith("prev_")
            ]
            result = sorted(set().union(*every))
            if not result:
                raise DataError(
                    "No file here is named as a frame of the object benchmark.",
                    path=self.folder,
                    remedy="Frames have six digits, such as label_2/000107.txt.",
                )
        for name in having:
            there = set(frame_ids(self.folder / name, file_suffix(name)))
            result = [id for id in result if id in there]
        return result

    @property
    def sensors(self) -> frozenset[Sensor]:
        """The LiDAR and the cameras that have a folder, which may lack files of some frames."""
        names = layout_folders(self.folder)
        cameras = [int(name.removeprefix("image_")) for name in names if name.startswith("image_")]
        return frozenset((*cameras, *([LIDAR] if "velodyne" in names else [])))

    def labels(self, id: str, *, keep_dont_care: bool = False) -> Boxes3D:
        """Ground truth of a frame; see `read_labels`."""
        return read_labels(self._file("label_2", id), keep_dont_care=keep_dont_care)

    def calibration(self, id: str) -> Calibration:
        """Calibration of a frame; see `read_calibration`."""
        return read_calibration(self._file("calib", id))

    def frame(self, id: str) -> SensorFrame:
        """All sensors of a frame: every image and scan that is there, loaded on demand.

        Its `previous` are up to three earlier frames (``prev_N``), which have no scan.

        Raises:
            DataError: The calibration is missing or broken.
        """
        calibration = self.calibration(id)
        images = self._images("image", f"{id}.png")
        scan = self.folder / "velodyne" / f"{id}.bin"
        previous = []
        for step in range(1, 4):
            earlier = self._images("prev", f"{id}_{step:02d}.png")
            if earlier:
                previous.append(
                    SensorFrame(
                        f"{id}_{step:02d}", calibration, LazyImages(earlier), origin=self.folder
                    )
                )
        return SensorFrame(
            id,
            calibration,
            LazyImages(images),
            ScanFile(scan) if is_file(scan) else None,
            tuple(previous),
            self.folder,
        )

    def drives_of(self, ids: Sequence[str]) -> list[str] | None:
        """The recorded drives that training frames come from: frames of one drive are alike.

        Returns:
            The folder of each frame's drive in KITTI raw; None where the devkit's ``mapping/`` is
            not there, or does not know all of these frames.

        Raises:
            DataError: The mapping is broken.
        """
        try:
            rand = self._find("mapping/train_rand.txt", "the devkit's mapping/")
        except DataError:
            return None
        mapping = read_raw_mapping(rand.parent)
        if any(id not in mapping for id in ids):
            return None
        return [mapping[id].folder for id in ids]

    def raw_origin(self, id: str) -> RawOrigin:
        """Where a training frame comes from in KITTI raw.

        Raises:
            DataError: The devkit's ``mapping/`` is not there, or does not know the frame.
        """
        folder = self._find("mapping/train_rand.txt", "the devkit's mapping/").parent
        mapping = read_raw_mapping(folder)
        if check_id(id) not in mapping:
            raise DataError(
                f"The mapping does not know frame {id}.",
                path=folder,
                remedy=f"It covers the {len(mapping)} training frames.",
            )
        return mapping[id]

    def _file(self, kind: str, id: str) -> Path:
        path = self.folder / kind / f"{check_id(id)}{file_suffix(kind)}"
        if not is_file(path):
            raise DataError(
                f"Frame {id} has no file in {kind}/.",
                path=path,
                remedy=f"Put KITTI's {kind} files into {self.folder / kind}/.",
            )
        return path

    def _images(self, kind: str, name: str) -> dict[int, ImageFile]:
        result = {}
        for folder in layout_folders(self.folder):
            match = _IMAGES.fullmatch(folder)
            path = self.folder / folder / name
            if match and match[1] == kind and is_file(path):
                result[int(match[2])] = ImageFile(path)
        return result

    def _find(self, name: str, what: str) -> Path:
        places = (self.folder, self.folder.absolute().parent, self.folder.absolute().parent.parent)
        for place in dict.fromkeys(places):
            for path in (place / name, place / "devkit_object" / name, place / "devkit" / name):
                if is_file(path):
                    return path
        raise DataError(
            f"There is no {name}.",
            path=self.root,
            remedy=f"Put {what} beside {self.folder.name}/ or inside it.",
        )


def layout_folders(folder: Path) -> list[str]:
    """Sorted names of the object layout's subfolders that a folder has."""
    try:
        return sorted(
            entry.name
            for entry in folder.iterdir()
            if (entry.name in SUFFIXES or _IMAGES.fullmatch(entry.name)) and entry.is_dir()
        )
    except (OSError, ValueError):
        return []


def file_suffix(name: str) -> str:
    """The suffix of the files in a subfolder of the layout."""
    return SUFFIXES.get(name, ".png")
