"""Samples that are as true as those there are: mirrored, enlarged, in other light."""

from __future__ import annotations

import numpy as np

from avsec_gym.perception.training.configuration import Augmentation
from avsec_gym.perception.training.photometric import relit
from avsec_gym.perception.training.sample import StereoSample
from avsec_gym.perception.training.stereo_flip import flipped
from avsec_gym.perception.training.zoom import zoomed


def augmented(
    sample: StereoSample, augmentation: Augmentation, randomness: np.random.Generator
) -> StereoSample:
    """A variation of a sample; the randomness decides which."""
    flip, zoom, left, top = randomness.uniform(size=4)
    if flip < augmentation.flip:
        sample = flipped(sample)
    if augmentation.zoom > 1:
        sample = zoomed(sample, 1 + (augmentation.zoom - 1) * zoom, left, top)
    return relit(sample, augmentation.photometric, randomness)
