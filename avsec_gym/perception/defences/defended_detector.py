"""A detector behind a defence of its images, and its loss for an attacker who knows of it."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from avsec_gym.argument_checks import seed_number, whole_number
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.perception.defences.box_vote import boxes_by_vote
from avsec_gym.perception.defences.image_defence import ImageDefence
from avsec_gym.perception.detectors.detector import (
    Detector,
    DifferentiableDetector,
    network_name,
)
from avsec_gym.registry import Kind, made_part

if TYPE_CHECKING:  # Detectors that only look things up need no torch.
    from torch import Tensor

    from avsec_gym.perception.stereo_batch import StereoBatch

_CAMERAS = (2, 3)
_MOST_COPIES = 1000


def defended_detector(
    detector: Any, defence: Any = "jpeg", copies: int = 1, seed: int = 0
) -> DefendedDetector:
    """Any detector of stereo pairs, which sees images only as a defence leaves them.

    What a defence draws depends on the image and the seed alone: the same frame gives the same
    boxes.

    Args:
        detector: The detector, by name, as a dictionary, or an object.
        defence: The defence by name likewise: ``jpeg``, ``bit_depth``, ``median_filter``,
            ``gaussian_noise``, or a plug-in's.
        copies: Number of defended copies that are looked at.  Of several, most must agree on an
            object: see `boxes_by_vote`.  Only a defence that draws something makes them differ.
        seed: Seed of what is drawn.

    Returns:
        A detector, with a loss if the given one has one: see `DifferentiableDefendedDetector`.

    Raises:
        ConfigurationError: There is none of that name, or a number that cannot be.

    Example:
        >>> defended_detector("oracle", {"name": "jpeg", "quality": 50}).name
        'oracle behind jpeg'
    """
    inner: Detector = made_part("detector", Kind.DETECTOR, detector)
    change: ImageDefence = made_part("defence", Kind.DEFENCE, defence)
    copies = whole_number("copies", copies, 1, _MOST_COPIES)
    if copies > 1 and getattr(inner, "image_only", False):
        raise ConfigurationError(
            f"copies is 1 for a detector of single images, such as {inner.name!r}: its boxes have"
            " no places, by which several looks could be compared"
        )
    seed = seed_number("seed", seed)
    if isinstance(inner, DifferentiableDetector):
        return DifferentiableDefendedDetector(inner, change, copies, seed)
    return DefendedDetector(inner, change, copies, seed)


class DefendedDetector:
    """A detector behind a defence; `defended_detector` makes it.

    Args:
        detector: The detector.
        defence: What happens to each image before.
        copies: Number of defended copies that vote.
        seed: Seed of what is drawn.
    """

    def __init__(self, detector: Detector, defence: ImageDefence, copies: int, seed: int) -> None:
        self._detector, self._defence = detector, defence
        self._copies, self._seed = copies, seed
        vote = f" x {copies}" if copies > 1 else ""
        self.name = f"{detector.name} behind {defence.name}{vote}"

    @property
    def network(self) -> Any:
        """The detector's network, if it has one: whose weights an attack was made for."""
        return getattr(self._detector, "network", None)

    @property
    def network_name(self) -> str:
        """See `avsec_gym.perception.detectors.detector.network_name`."""
        return network_name(self._detector)

    @property
    def configuration(self) -> Any:
        """The network's configuration, if it has one: whose width rendered cameras have."""
        return getattr(self._detector, "configuration", None)

    @property
    def image_only(self) -> bool:
        """Whether its boxes lie in the image alone; see `avsec_gym.image_only.check_detector`."""
        return bool(getattr(self._detector, "image_only", False))

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """What the detector sees in the defended images of the stereo pair.

        Raises:
            DataError: The frame lacks what the detector needs, or an image of the pair.
        """
        found = []
        for copy in range(self._copies):
            seen = frame
            for camera in _CAMERAS:
                seen = seen.with_image(camera, self._defended(frame.image(camera), copy))
            found.append(self._detector.detect(seen))
        return self._voted(found)

    def _voted(self, found: Sequence[Boxes3D]) -> Boxes3D:
        return found[0] if self._copies == 1 else boxes_by_vote(found)

    def _defended(self, image: Image, copy: int) -> Image:
        """A copy of an image behind the defence; what it draws follows from the image."""
        pixels = np.rint(np.clip(image, 0, 255)).astype(np.uint8)
        digest = hashlib.blake2b(np.ascontiguousarray(pixels).tobytes(), digest_size=8).digest()
        drawn = np.random.default_rng((self._seed, copy, int.from_bytes(digest)))
        return self._defence.defend(pixels, drawn)


class DifferentiableDefendedDetector(DefendedDetector):
    """A defended detector whose loss reaches the camera's pixels, for an attacker who knows it.

    A defence that rounds has no gradient of use: behind it, attacks that take its gradient for that
    of the detector fail, and the defence seems strong.  Here the gradient passes the defence as if
    it were the identity (backward pass differentiable approximation), and what it draws is averaged
    over the copies (expectation over transformation; both Athalye et al. 2018).
    """

    _detector: DifferentiableDetector

    def detect_batch(self, batch: StereoBatch) -> list[Boxes3D]:
        """See `DifferentiableDetector.detect_batch`."""
        copies = [self._detector.detect_batch(self._behind(batch, k)) for k in range(self._copies)]
        return [self._voted(found) for found in zip(*copies, strict=True)]

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        """See `DifferentiableDetector.losses`; the mean over the copies."""
        every = [
            self._detector.losses(self._behind(batch, copy), truth, disparity)
            for copy in range(self._copies)
        ]
        import torch

        return {name: torch.stack([each[name] for each in every]).mean(0) for name in every[0]}

    def _behind(self, batch: StereoBatch, copy: int) -> StereoBatch:
        """The batch behind the defence; the gradient passes as if nothing had happened."""
        return replace(
            batch,
            left=batch.left + self._change(batch.left, copy),
            right=batch.right + self._change(batch.right, copy),
        )

    def _change(self, images: Tensor, copy: int) -> Tensor:
        """What the defence adds to images of shape (B, 3, H, W), without a gradient."""
        import torch

        pixels = images.detach().permute(0, 2, 3, 1).cpu().numpy()
        defended = np.stack([self._defended(each, copy) for each in pixels])
        seen = torch.from_numpy(defended).permute(0, 3, 1, 2).to(images)
        return seen - images.detach()
