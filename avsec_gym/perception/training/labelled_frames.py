"""Labelled frames of several folders in one order: what all samples of detectors are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject, file_suffix


@dataclass(frozen=True)
class DataFrames:
    """Frames of a folder in the object layout."""

    data: KittiObject
    ids: tuple[str, ...]


@dataclass(frozen=True)
class FramePlace:
    """Where a frame is.

    Args:
        data: The folder.
        id: The frame's id in this folder.
    """

    data: KittiObject
    id: str

    def file(self, kind: str) -> Path:
        """Its file in a folder such as ``velodyne``."""
        return self.data.folder / kind / f"{self.id}{file_suffix(kind)}"

    def frame(self) -> SensorFrame:
        """All sensors."""
        return self.data.frame(self.id)

    def labels(self, *, keep_dont_care: bool = False) -> Boxes3D:
        """What is labelled; regions not to care about only if asked for."""
        return self.data.labels(self.id, keep_dont_care=keep_dont_care)


def frame_places(frames: Sequence[DataFrames], cache: Path) -> list[FramePlace]:
    """The frames of all folders, one after the other.

    Raises:
        DataError: There is none; the cache of what was to be made of them is named.
    """
    places = [FramePlace(source.data, id) for source in frames for id in source.ids]
    if not places:
        raise DataError("There is no frame to train on.", path=cache)
    return places


class LabelledFrames:
    """Frames as they are, beside what networks see of them; see the classes that inherit it."""

    def __init__(self, places: Sequence[FramePlace]) -> None:
        self._places = places

    def __len__(self) -> int:
        return len(self._places)

    def frame(self, index: int) -> SensorFrame:
        """The frame itself, at the cameras' own size, its scan as it was."""
        return self._places[index].frame()

    @cached_property
    def labels(self) -> list[Boxes3D]:
        """Every line of the label files, 2D boxes in pixels of the camera's own image."""
        return [place.labels(keep_dont_care=True) for place in self._places]
