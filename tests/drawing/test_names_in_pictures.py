"""Names of files and parts stand in pictures letter for letter, whatever they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.film_strip import ShownDrive, clip
from avsec_gym.drawing.found_and_true import draw_frame, draw_frames_from_above
from avsec_gym.drawing.precision_recall import draw_precision_recall
from avsec_gym.drawing.scenario_picture import draw_episode, picture_array
from avsec_gym.frame import SensorFrame
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.pipeline import run_episode
from avsec_gym.rig import kitti_rig
from avsec_gym.scenario.intention import Intention
from tests.drawing.test_film_picture import film
from tests.drawing.test_scenario_picture import scene

NAMES = ("left$^$_", "5$ or 6$", r"$\frac$", "\udcc3\udca9", "a_b^c", "")
"""Halves of formulas, dollars, and bytes that are no text where the locale is POSIX's."""


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_any_name_is_drawn(name: str, tmp_path: Path) -> None:
    nothing = Boxes3D.empty()
    picture_array(draw_episode(run_episode(scene([]), Intention.STRAIGHT), title=name))
    black = {2: np.zeros((375, 1242, 3), np.uint8)}
    frame = SensorFrame("000000", kitti_rig().calibration, black)
    picture_array(draw_frame(frame, nothing, {name: nothing}, title=name))
    picture_array(draw_frames_from_above({name: (nothing, {name: nothing})}))
    picture_array(draw_precision_recall(average_precision([nothing], [nothing]), title=name))
    clip([ShownDrive(name, film(), name, bad=False)])
