"""What an attack on images is: a frame in, a frame out, seeded, with a budget that is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.scenario.intention import Intention

if TYPE_CHECKING:  # Attacks that only copy pixels need no torch.
    from torch import Tensor

Seed = int | Sequence[int]
"""A seed of `numpy.random.default_rng`."""

LEFT, RIGHT = 2, 3
"""The cameras that stereo detectors look through."""


@dataclass(frozen=True, eq=False)
class Victim:
    """The attacker's knowledge of the attacked car; each attack uses as much as it needs.

    Args:
        detector: The detector O; an attack by gradient needs a `DifferentiableDetector`.
        truth: Real objects, b^true.
        intention: Driving intention of the car; a specific attack aims at it.
        disparity: Disparity of the left image in pixels of the camera, 0 where unknown, shape (H,
            W); DSGN's training loss has a term for it.
    """

    detector: Detector
    truth: Boxes3D
    intention: Intention | None = None
    disparity: NDArray[np.float32] | None = None


@dataclass(frozen=True)
class Budget:
    """What an attack may change at most.

    Args:
        change: Largest change of any channel of any pixel, grey levels.
        area: Number of pixels of one image that may change at all; None: every one.
    """

    change: float
    area: int | None = None

    def exceeded_by(self, clean: SensorFrame, attacked: SensorFrame) -> bool:
        """Whether either image was changed by more."""
        for camera in (LEFT, RIGHT):
            change = np.abs(np.subtract(attacked.image(camera), clean.image(camera), dtype=float))
            if change.max() > self.change + 1e-3:
                return True
            if self.area is not None and (change.max(axis=2) > 1e-3).sum() > self.area:
                return True
        return False


@runtime_checkable
class Attack(Protocol):
    """Anything that tampers with what the cameras deliver."""

    name: str

    @property
    def budget(self) -> Budget:
        """What it may change at most."""
        ...

    def attack(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> SensorFrame:
        """The frame as the victim gets it, with grey levels that are float32 in [0, 255].

        The same frame, victim and seed give the same pixels, in every process.

        Raises:
            ConfigurationError: The victim lacks what this attack needs.
            DataError: An image is missing or broken.
        """
        ...


def with_pair(frame: SensorFrame, left: Tensor, right: Tensor) -> SensorFrame:
    """The same frame with other images, shape (3, H, W) each, grey levels, kept as float32."""
    for camera, image in ((LEFT, left), (RIGHT, right)):
        pixels = image.detach().clamp(0, 255).permute(1, 2, 0).float().cpu().contiguous().numpy()
        frame = frame.with_image(camera, cast(Image, pixels))
    return frame


def quantised(frame: SensorFrame) -> SensorFrame:
    """The frame with whole grey levels, uint8, as a camera's bus or an image file carries them."""
    for camera in (LEFT, RIGHT):
        image = frame.image(camera)
        if image.dtype != np.uint8:
            frame = frame.with_image(camera, np.rint(image).astype(np.uint8))
    return frame
