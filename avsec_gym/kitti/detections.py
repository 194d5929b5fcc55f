"""A detector's result folder, as OpenPCDet, mmdetection3d and KITTI's server use it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.image_only import WHAT_IT_IS_FOR, is_image_only
from avsec_gym.kitti.label_folders import check_id, frame_ids
from avsec_gym.kitti.labels import read_detections
from avsec_gym.kitti.result_place import result_folder


class DetectionFolder:
    """Result files named by frame, such as ``000107.txt``.

    Args:
        path: The folder that holds the files, or one above it, as long as there is but one such
            folder: of OpenPCDet ``final_result/data``, or its whole output.

    Raises:
        DataError: There is no such folder, no result file in it, or several folders below it hold
            some.
    """

    def __init__(self, path: str | Path) -> None:
        self.folder = result_folder(Path(path))
        self._ids = frame_ids(self.folder, ".txt")

    def ids(self) -> list[str]:
        """The frames that have a file, sorted."""
        return list(self._ids)

    def read(
        self,
        ids: Iterable[str] | None = None,
        broken: dict[str, DataError] | None = None,
        *,
        image_only: bool = False,
    ) -> tuple[dict[str, Boxes3D], list[str]]:
        """Detections of the frames asked for.

        Args:
            ids: Frames; all that have a file if None.
            broken: Dictionary that gets the errors of broken files by id, whose frames are then
                left out; None: the first is raised.
            image_only: Whether 2D boxes without a place in space are fine: they can be scored, but
                no car can drive by them.

        Returns:
            Boxes by id in the order asked for, and the ids that have no file: a detector that
            found nothing often writes none, so these count as empty, and the caller reports them.

        Raises:
            DataError: A file is broken, none of the frames asked for has a file, or some boxes are
                known in the image only and that is not fine.
        """
        wanted = self._ids if ids is None else [check_id(id) for id in ids]
        there = set(self._ids)
        missing = [id for id in dict.fromkeys(wanted) if id not in there]
        if wanted and len(missing) == len(set(wanted)):
            raise DataError(
                f"None of the {len(missing)} frames asked for has a result file.",
                path=self.folder,
                remedy=f"The folder begins with {self._ids[0]}, frames asked for with "
                f"{missing[0]}: is it the result of another split?",
            )
        found = {}
        for id in wanted:
            try:
                path = self.folder / f"{id}.txt"
                found[id] = read_detections(path) if id in there else Boxes3D.empty()
            except DataError as error:
                if broken is None:
                    raise
                broken[id] = error
        if not image_only:
            self._check_places(found)
        return found, missing

    def _check_places(self, found: dict[str, Boxes3D]) -> None:
        """Raise DataError where a box is nowhere.

        Even one is too many: what a detector saw would silently be no obstacle.
        """
        lost = {id: int(is_image_only(boxes).sum()) for id, boxes in found.items()}
        frames = [id for id, count in lost.items() if count]
        if frames:
            raise DataError(
                f"{sum(lost.values())} of {sum(map(len, found.values()))} detections have no 3D box"
                f" (in {len(frames)} of {len(found)} frames, the first {frames[0]}): no car can"
                " drive by what is known in the image only, it would take the road for free.",
                path=self.folder,
                remedy="Give the results of a detector of 3D boxes, or leave these lines out if the"
                f" car is not to know of them; {WHAT_IT_IS_FOR}.",
            )


def above(boxes: Boxes3D, threshold: float) -> Boxes3D:
    """The boxes whose score is at least the threshold."""
    return boxes[boxes.score >= threshold]


def default_score_threshold(scores: ArrayLike) -> float:
    """The threshold for all of a detector's scores when the user gives none.

    Returns:
        0.3 where every score can be a probability, 0 where scores have no bounds.

    Example:
        >>> default_score_threshold([0.2, 0.9]), default_score_threshold([0.2, 4.1])
        (0.3, 0.0)
    """
    values = np.asarray(scores, float)
    return 0.3 if ((values >= 0) & (values <= 1)).all() else 0.0
