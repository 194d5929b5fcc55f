"""A detector of single images in the place of any other: it looks at one camera."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

from avsec_gym.argument_checks import camera_number
from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.image_detector import ImageDetector
from avsec_gym.registry import Kind, made_part


@dataclass(frozen=True)
class SingleImage:
    """Boxes of one image; see `image_boxes`: no car can drive by them, but they can be scored.

    Args:
        detector: What `make_image_detector` takes.
        camera: The camera whose image is looked at.

    Raises:
        ConfigurationError: No such detector, or no camera's number.
    """

    detector: Any
    camera: int = 2
    image_only: ClassVar[bool] = True
    """See `avsec_gym.image_only.check_detector`."""
    name: str = field(init=False)
    _detector: ImageDetector = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "camera", camera_number("camera", self.camera))
        detector = made_part("detector", Kind.IMAGE_DETECTOR, self.detector)
        object.__setattr__(self, "_detector", detector)
        object.__setattr__(self, "name", self._detector.name)

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """Detect as `ImageDetector.detect` does."""
        return self._detector.detect(frame, self.camera)
