"""What is said of sensors stands in the picture whole."""

from __future__ import annotations

import numpy as np
from matplotlib.text import Text

from avsec_gym.frame import SensorFrame
from avsec_gym.report.validation_picture import draw_validation
from avsec_gym.rig import camera_rig
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.disparity_error import DisparityErrors
from avsec_gym.validation.disparity_maps import DisparityMaps
from avsec_gym.validation.state_posterior import Verdict
from avsec_gym.validation.validator import Validation

RIG = camera_rig([0.0, 0.4, 0.6], focal_length=200.0, centre=(207.0, 62.0), size=(414, 125))
SYSTEM = SensorSystem((LIDAR, 2, 1, 0))


def test_the_longest_titles_are_not_cut_off() -> None:
    dots = np.random.default_rng(0).integers(0, 256, (125, 480, 3), np.uint8)
    images = {camera: dots[:, 5 * shift :][:, :414] for camera, shift in enumerate((0, 2, 3))}
    frame = SensorFrame("0", RIG.calibration, images, np.zeros((0, 4), np.float32))
    errors = DisparityErrors(DisparityMaps(frame, SYSTEM))
    assert len(dict(errors)) == len(SYSTEM.triples)
    verdicts = dict.fromkeys(SYSTEM.sensors, Verdict.CANNOT_TELL)
    doubtful = Validation(True, verdicts, errors, dict.fromkeys(SYSTEM.sensors, 0.5))
    figure = draw_validation(doubtful, dict.fromkeys(SYSTEM.triples, 0.123))
    figure.canvas.draw()
    named = [text for text in figure.findobj(Text) if "LiDAR" in text.get_text()]
    named += [text for text in figure.findobj(Text) if text.get_text().startswith("camera")]
    assert len(named) == 7
    assert sum("(threshold 0.123)" in text.get_text() for text in named) == 3
    for text in named:
        extent = text.get_window_extent()
        assert extent.x0 >= 0
        assert extent.x1 <= figure.bbox.x1
        assert extent.y1 <= figure.bbox.y1
