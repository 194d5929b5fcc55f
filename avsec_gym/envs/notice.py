"""What an attacker gets to know of a validator: whether it raises an alarm, and how near it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.registry import Kind, make
from avsec_gym.scenario.frame_scenes import FrameScenes

if TYPE_CHECKING:  # OpenCV is loaded where somebody validates, not before.
    from avsec_gym.validation.thresholds import ThresholdTable
    from avsec_gym.validation.validator import Validator

CLEAN = 50
"""Scenes at most that thresholds are measured on."""
MEASURES = ("error", "hole_share", "densest", "brightness")
"""See `avsec_gym.validation.disparity_error.DisparityError`."""


@dataclass(frozen=True, eq=False)
class Notice:
    """What a validator says of one moment.

    Args:
        alarm: Whether it noticed something.
        shares: Of each of `MEASURES` the largest of the triples that it looked at, in [0, 1],
            shape (4,).
    """

    alarm: bool
    shares: Floats

    @classmethod
    def of(cls, validator: Validator | None, frame: SensorFrame) -> Notice:
        """Let it look; nobody notices nothing."""
        nothing = np.zeros(len(MEASURES))
        if validator is None:
            return cls(False, nothing)
        validation = validator.validate(frame)
        known = [validation.errors[triple].shares for triple in validation.errors.known]
        return cls(validation.alarm, np.max([nothing, *known], axis=0))

    @property
    def facts(self) -> dict[str, Any]:
        """For `info`."""
        return {"noticed": self.alarm} | dict(zip(MEASURES, self.shares.tolist(), strict=True))


def validator_for(what: Any, clean: FrameScenes) -> Validator | None:
    """A validator of the LiDAR and the cameras 3 and 2.

    Args:
        what: A name, a dictionary of a name and arguments, or a live one; None: nobody looks.
            ``thresholds`` without a table is given one that is measured on clean scenes.
        clean: Attack-free scenes, of which the first `CLEAN` count; environments take those that
            they play unless told otherwise, and of 50 scenes none may lie beyond r = 0.01, as at 0.

    Raises:
        ConfigurationError: Nothing has that name, or its arguments cannot be.
        DataError: A clean scene lacks an image or the scan.
    """
    if what is None:
        return None
    if what == "thresholds":
        what = {"name": what}
    if isinstance(what, Mapping) and what.get("name") == "thresholds" and "thresholds" not in what:
        what = {**what, "thresholds": _measured(clean)}
    return cast("Validator", make(Kind.VALIDATOR, what))


@lru_cache(maxsize=8)
def _measured(clean: FrameScenes) -> ThresholdTable:
    from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
    from avsec_gym.validation.pair_depth import PairDepth
    from avsec_gym.validation.thresholds import measured_thresholds

    scenes = clean.scenes.labelled[:CLEAN]
    frames = (clean.frame(scene) for scene in scenes)
    data = {"scenes": clean.scenes.name, "moments": len(scenes)}
    return measured_thresholds(frames, LIDAR_AND_TWO_CAMERAS, PairDepth(), data)
