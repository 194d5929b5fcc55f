"""What a trained patch depends on."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from avsec_gym.attacks.patch_ghosts import ghost_width
from avsec_gym.attacks.patch_placement import RADIUS, PatchRange
from avsec_gym.errors import ConfigurationError

_LAST_STEP = 0.1


@dataclass(frozen=True)
class PatchTraining:
    """What a patch depends on, besides detectors and frames.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    epochs: int = 10
    """Passes over the frames; each draws new places, disparities and rotations."""
    batch: int = 4
    """Frames in a step, each with a place of its own."""
    step_size: float = 8.0
    """Step size of Adam, grey levels; it falls linearly, to a tenth in the last step."""
    radius: float = RADIUS
    """Pixels of the camera's own image."""
    range: PatchRange = field(default_factory=PatchRange)
    """Where it stands: `nearest` 5 and `farthest` 20 metres are all distances at which a ghost is
    in a car's way."""
    ghost_width: float | None = None
    """Width of b*, metres, up to a full car's 1.63; height and length go with it.  Default: what
    the patch shows of a car at its distance."""
    seed: int = 0
    """Seed of the order, places, disparities and rotations."""
    keep_real: bool = field(
        default=True,
        metadata={
            "help": "Do not count real objects to b*, which is then the ghost alone: all the rest"
            " is to vanish."
        },
    )
    """b* are the ghost and the real objects, because the attack is to put ghosts in and cannot
    reach what is far from the patch; else the ghost alone, and all the rest is to vanish."""

    def __post_init__(self) -> None:
        if self.ghost_width is not None:
            object.__setattr__(self, "ghost_width", ghost_width(self.ghost_width))
        if min(self.epochs, self.batch) < 1 or self.seed < 0:
            raise ConfigurationError(
                f"epochs and batch are 1 or more, the seed 0 or more, got {self}"
            )
        if not (0 < self.step_size < np.inf and 0 < self.radius < np.inf):
            raise ConfigurationError(f"step size and radius are positive, got {self}")

    def step_size_at(self, share: float) -> float:
        """The step size, grey levels, when this share of the training is done."""
        return self.step_size * (1 - (1 - _LAST_STEP) * share)
