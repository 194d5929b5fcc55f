"""The frames that a patch is trained on, with what is really there."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any, Protocol

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.world.export import read_manifest

_NEEDED = ("image_2", "image_3", "label_2", "calib")


class PatchScenes(Protocol):
    """Frames by number, loaded when asked for."""

    def __len__(self) -> int:
        """How many there are."""
        ...

    def __getitem__(self, index: int) -> tuple[SensorFrame, Boxes3D]:
        """A frame and the real objects."""
        ...

    def description(self) -> dict[str, Any]:
        """JSON-able: which frames they are."""
        ...


@dataclass(frozen=True)
class KittiScenes:
    """Frames of a folder in the object layout."""

    data: KittiObject
    ids: tuple[str, ...]

    @classmethod
    def of_split(
        cls, data: KittiObject, split: str | None = None, limit: int | None = None
    ) -> KittiScenes:
        """The frames of a split, or all, that have both images, labels and a calibration.

        Raises:
            DataError: The split is not there, or has no such frame.
        """
        ids = tuple(data.ids(split, _NEEDED))[:limit]
        if not ids:
            which = "frame" if split is None else f"frame of the split {split!r}"
            raise DataError(
                f"No {which} has a file in each of {', '.join(_NEEDED)}.",
                path=data.root,
                remedy="`avsec world make` makes such data; `avsec data check` lists what is here.",
            )
        return cls(data, ids)

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, index: int) -> tuple[SensorFrame, Boxes3D]:
        return self.data.frame(self.ids[index]), self.data.labels(self.ids[index])

    def description(self) -> dict[str, Any]:
        """See `PatchScenes`."""
        listed = "\n".join(self.ids).encode()
        return {
            "name": self.data.root.name,
            "fingerprint": (read_manifest(self.data.root) or {}).get("fingerprint"),
            "frames": len(self.ids),
            "ids_sha256": hashlib.sha256(listed).hexdigest(),
        }
