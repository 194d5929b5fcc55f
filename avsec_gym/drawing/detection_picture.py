"""What a car believed to see, and where that led it: an image with boxes above the episode."""

from __future__ import annotations

import cv2
import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.frame_picture import with_boxes
from avsec_gym.drawing.scenario_picture import draw_episode, picture_array
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.pipeline import Episode


def detection_picture(
    frame: SensorFrame, believed: Boxes3D, episode: Episode, *, camera: int = 2
) -> Image:
    """The camera's image with the believed boxes; beneath it, in its width, the episode.

    Args:
        frame: Images and scan of the scene.
        believed: Believed objects.
        episode: The planned trajectory and its check.
        camera: Number of the camera whose image is drawn on.
    """
    image = with_boxes(frame.image(camera), believed, frame.calibration, camera)
    plan = picture_array(draw_episode(episode))
    height = round(plan.shape[0] * image.shape[1] / plan.shape[1])
    below = cv2.resize(plan, (image.shape[1], height), interpolation=cv2.INTER_AREA)
    return np.concatenate([image, below])
