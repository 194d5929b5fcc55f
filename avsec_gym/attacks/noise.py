"""Random noise: the control that a perturbation attack of the same size has to beat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from avsec_gym.argument_checks import flag, label, number
from avsec_gym.attacks.argument_domains import LEVELS
from avsec_gym.attacks.attack import LEFT, RIGHT, Budget, Seed, Victim, with_pair
from avsec_gym.frame import SensorFrame


@dataclass(frozen=True)
class RandomNoise:
    """Every channel of every pixel of both views, moved at random.

    Args:
        strength: Largest change, grey levels.
        uniform: Whether a change lies anywhere in [-strength, strength]; by default it is one of
            the two ends, as large as that of an attack along the gradient's sign.
        name: Name of the attack in results.

    Raises:
        ConfigurationError: The strength is not above 0 and up to 255, or no flag or name is one.
    """

    strength: float = 4.0
    uniform: bool = False
    name: str = "random_noise"

    def __post_init__(self) -> None:
        object.__setattr__(self, "strength", number("strength", self.strength, *LEVELS))
        object.__setattr__(self, "uniform", flag("uniform", self.uniform))
        label("name", self.name)

    @property
    def budget(self) -> Budget:
        """The strength."""
        return Budget(self.strength)

    def attack(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> SensorFrame:
        """The frame with noise; the victim is not looked at.  See `Attack.attack`."""
        pair = frame.stereo(LEFT, RIGHT)
        images = np.stack([pair.left, pair.right]).astype(np.float32)
        random = np.random.default_rng(seed)
        if self.uniform:
            noise = random.uniform(-1.0, 1.0, images.shape).astype(np.float32)
        else:
            noise = random.choice(np.array([-1.0, 1.0], np.float32), images.shape)
        noisy = torch.from_numpy(images + self.strength * noise).permute(0, 3, 1, 2)
        return with_pair(frame, noisy[0], noisy[1])
