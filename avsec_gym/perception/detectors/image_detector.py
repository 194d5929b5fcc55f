"""What a detector of single images is: 2D boxes of what one camera sees."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.image_only import NOWHERE, UNKNOWN_ANGLE, UNKNOWN_SIZE

if TYPE_CHECKING:
    from torch import Tensor


@runtime_checkable
class ImageDetector(Protocol):
    """Anything that finds objects in an image; see `image_boxes` for what comes out."""

    name: str

    def detect(self, frame: SensorFrame, camera: int = 2) -> Boxes3D:
        """The objects in a camera's image, best score first.

        Raises:
            DataError: The frame has no image of this camera, or its file is broken.
        """
        ...

    def detect_image(self, image: Image) -> Boxes3D:
        """The objects in an image of shape (H, W, 3), best score first."""
        ...


@runtime_checkable
class DifferentiableImageDetector(ImageDetector, Protocol):
    """A detector whose training loss reaches the pixels."""

    def detect_batch(self, images: Tensor) -> list[Boxes3D]:
        """Detect in images (B, 3, H, W), grey levels 0..255, as `detect_image`; no gradient."""
        ...

    def losses(self, images: Tensor, truth: Sequence[Boxes3D]) -> dict[str, Tensor]:
        """The terms of the training loss against the truth, whose sum is the loss L.

        Args:
            images: Grey levels 0..255, shape (B, 3, H, W); whatever the network scales or
                normalises happens inside, so that the gradient is that of these pixels.
            truth: What is really there, 2D boxes in these pixels, for each image.
        """
        ...


def image_boxes(box2d: Floats, score: Floats, category: Sequence[str]) -> Boxes3D:
    """Objects that are known in the image only.

    Their place in space is KITTI's placeholder for results without one, -1000 m: they are scored
    in the image, and no car drives by them, see `avsec_gym.image_only`.

    Args:
        box2d: Left, top, right, bottom, pixels, shape (N, 4).
        score: The scores, shape (N,).
        category: Names such as ``Car``.

    Example:
        >>> found = image_boxes(np.array([[10.0, 20, 60, 50]]), np.array([0.9]), ["Car"])
        >>> found.location[0].tolist()
        [-1000.0, -1000.0, -1000.0]
    """
    count = len(score)
    return Boxes3D(
        np.full((count, 3), NOWHERE),
        np.full((count, 3), UNKNOWN_SIZE),
        np.full(count, UNKNOWN_ANGLE),
        score,
        np.array(category, np.str_),
        box2d=box2d,
        alpha=np.full(count, UNKNOWN_ANGLE),
    )
