"""A detector that finds nothing, for doubles of which only the losses are asked."""

from __future__ import annotations

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.stereo_batch import StereoBatch


class FindsNothing:
    """The part of a detector that these tests do not look at."""

    def detect(self, frame: SensorFrame) -> Boxes3D:
        return Boxes3D.empty()

    def detect_batch(self, batch: StereoBatch) -> list[Boxes3D]:
        return [Boxes3D.empty()] * len(batch)
