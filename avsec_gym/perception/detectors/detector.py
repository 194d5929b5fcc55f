"""What a detector is: b = O(I_l, I_r); and its loss, if it can be attacked by gradient."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame

if TYPE_CHECKING:  # Detectors that only look things up need no torch.
    from torch import Tensor

    from avsec_gym.perception.stereo_batch import StereoBatch


@runtime_checkable
class Detector(Protocol):
    """Anything that finds objects in what the sensors deliver."""

    name: str

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """The objects of a frame, best score first, with 2D boxes (KITTI needs them), alpha set.

        Raises:
            DataError: The frame lacks what this detector needs.
        """
        ...


def network_name(detector: Detector) -> str:
    """The name of the network that looks, behind whichever defence: patches are filed under it."""
    return str(getattr(detector, "network_name", detector.name))


@runtime_checkable
class DifferentiableDetector(Detector, Protocol):
    """A detector whose training loss reaches the pixels."""

    def detect_batch(self, batch: StereoBatch) -> list[Boxes3D]:
        """Detect, as `detect` does, in pairs that are tensors already; without gradient."""
        ...

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        """The terms of the training loss against the truth, whose sum is the loss L.

        Args:
            batch: B pairs.
            truth: What is really there, for each pair.
            disparity: The disparities of the left image, pixels of the batch's own resolution,
                shape (B, H, W), 0 where unknown; without it, a term that needs it is left out.

        Pixels are grey levels 0..255 at the camera's own resolution; whatever the network scales
        or normalises happens inside, so that the gradient is that of the camera's pixels.
        """
        ...
