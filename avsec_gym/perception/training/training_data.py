"""Which frames a network is trained and validated on."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.perception.training.labelled_frames import DataFrames
from avsec_gym.perception.training.training_assets import training_suite
from avsec_gym.storage.regular_files import is_folder
from avsec_gym.world.export import read_manifest

NEEDED = ("image_2", "image_3", "label_2", "calib")
"""Folders in which a frame must have a file."""

_SUITES = ("street", "highway", "mixed")
_REMEDY = (
    "`avsec world make --suite mixed --assets train --frames 2000 --out {root}` makes data to train"
    " on."
)


@dataclass(frozen=True)
class TrainingData:
    """Folders in KITTI's object layout with their splits ``train`` and ``val``.

    Args:
        training: Frames to learn from.
        validation: Frames to validate on, none of them among the others.
    """

    training: tuple[DataFrames, ...]
    validation: tuple[DataFrames, ...]

    def description(self) -> dict[str, Any]:
        """JSON-able: how the data were made, and which frames they are."""
        return {
            "training": [described(source) for source in self.training],
            "validation": [described(source) for source in self.validation],
        }


def training_data(
    roots: Sequence[str | Path] = (),
    validation: Sequence[str | Path] = (),
    *,
    needed: Sequence[str] = NEEDED,
) -> TrainingData:
    """The frames of folders.

    Args:
        roots: The folders, each with ``ImageSets/train.txt`` and, without `validation`,
            ``val.txt``; small suites of training assets, made on first use, if there are none.
        validation: Folders all of whose frames are validated on; all frames of `roots` are
            then learned from.
        needed: Folders in which a frame must have a file.

    Raises:
        DataError: A folder or a split is not there, or has no such frame; the command that
            makes it is named.
    """
    # Before suites are made, or many frames listed.
    for root in map(Path, (*roots, *validation)):
        if not is_folder(root):
            remedy = _REMEDY.format(root=root)
            raise DataError("There is no such folder.", path=root, remedy=remedy)
    folders = [Path(root) for root in roots] or [training_suite(name) for name in _SUITES]
    if validation:
        return TrainingData(
            tuple(_frames(root, None, needed) for root in folders),
            tuple(_frames(Path(root), None, needed) for root in validation),
        )
    return TrainingData(
        tuple(_frames(root, "train", needed) for root in folders),
        tuple(_frames(root, "val", needed) for root in folders),
    )


def _frames(root: Path, split: str | None, needed: Sequence[str]) -> DataFrames:
    data = KittiObject(root)
    ids = tuple(data.ids(split, needed))
    if not ids:
        which = "frame" if split is None else f"frame of the split {split!r}"
        raise DataError(
            f"No {which} has a file in each of {', '.join(needed)}.",
            path=root,
            remedy=_REMEDY.format(root=root),
        )
    return DataFrames(data, ids)


def described(source: DataFrames) -> dict[str, Any]:
    """JSON-able: how frames were made, how many there are, and a hash of their ids."""
    manifest = read_manifest(source.data.root) or {}
    listed = "\n".join(source.ids).encode()
    return {
        "name": source.data.root.name,
        "settings": manifest.get("settings"),
        "fingerprint": manifest.get("fingerprint"),
        "frames": len(source.ids),
        "ids_sha256": hashlib.sha256(listed).hexdigest(),
    }
