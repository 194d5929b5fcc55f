"""How a network is trained, how its samples are varied, and on what machine it runs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from avsec_gym.errors import ConfigurationError


@dataclass(frozen=True)
class TrainingConfiguration:
    """Everything that a trained network depends on, besides the network and the data.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    epochs: int = 60
    """Passes over the training samples; the learning rate's cycle spans them all."""
    batch: int = 4
    """Samples in a step."""
    learning_rate: float = 1e-3
    """The highest, of AdamW."""
    warm_up: float = 0.05
    """Share of all steps in which the rate rises; 0.3 makes it a one-cycle schedule."""
    final_rate: float = 0.01
    """The last rate, as a share of the highest."""
    weight_decay: float = 1e-4
    """The decay of weights; there is none of biases and normalisations."""
    clip: float = 10.0
    """Longest gradient; a longer one is shortened to it."""
    average: float = 0.998
    """Decay of the running average of the weights, which is what is validated and kept."""
    validate_every: int = 1
    """Epochs between validations."""
    patience: int | None = None
    """Stop after so many validations without a better one.  Default: never."""
    arithmetic: Literal["measured", "float32", "bfloat16"] = "measured"
    """Numbers to calculate in.  Measured: bfloat16, where it is safe, if a few steps at the start
    are clearly quicker in it.  A run goes on with what it began with."""
    seed: int = 0
    """Seed of first weights, order, augmentation and sampling."""

    def __post_init__(self) -> None:
        counts = (self.epochs, self.batch, self.validate_every, self.patience or 1)
        if min(counts) < 1 or self.seed < 0:
            raise ConfigurationError(
                f"epochs, batch, validate_every and patience are 1 or more, the seed 0, got {self}"
            )
        if not (self.learning_rate > 0 and self.clip > 0 and self.weight_decay >= 0):
            raise ConfigurationError(
                "learning rate and clip are positive, weight decay is 0 or more, got "
                f"{self.learning_rate}, {self.clip} and {self.weight_decay}"
            )
        if not (0 <= self.warm_up < 1 and 0 <= self.final_rate <= 1 and 0 <= self.average < 1):
            raise ConfigurationError(
                "warm_up, final_rate and average are shares, got "
                f"{self.warm_up}, {self.final_rate} and {self.average}"
            )


@dataclass(frozen=True)
class Photometric:
    """How far light and cameras may differ; 0 everywhere leaves images as they are.

    Raises:
        ConfigurationError: A negative number.
    """

    brightness: float = 0.2
    """Largest change of the logarithm of all grey levels."""
    contrast: float = 0.2
    """The same of their distance from the image's mean."""
    gamma: float = 0.2
    """The same of the exponent."""
    saturation: float = 0.3
    """The same of colours' distance from grey."""
    tint: float = 0.05
    """The same of each colour by itself."""
    between_views: float = 0.15
    """How much the two views may differ, as a share of the changes above."""
    noise: float = 4.0
    """Largest standard deviation of a pixel's noise, grey levels."""
    grey: float = 0.0
    """Share of samples whose colours are taken away in both views, as of grey cameras."""

    def __post_init__(self) -> None:
        if min(vars(self).values()) < 0 or self.grey > 1:
            raise ConfigurationError(f"photometric changes are 0 or more, got {self}")


@dataclass(frozen=True)
class Augmentation:
    """How samples are varied.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    flip: float = 0.5
    """Share of mirrored samples."""
    zoom: float = 1.1
    """Largest enlargement; 1 for none."""
    photometric: Photometric = field(default_factory=Photometric)
    """Light and cameras."""

    def __post_init__(self) -> None:
        if not (0 <= self.flip <= 1 <= self.zoom < 4):
            raise ConfigurationError(
                f"flip is a share and zoom in [1, 4), got {self.flip} and {self.zoom}"
            )


@dataclass(frozen=True)
class Machine:
    """What a training runs on; a run may go on on another machine.

    Raises:
        ConfigurationError: A number that cannot be.
    """

    device: str = "cpu"
    """Device of torch, such as cpu or cuda; all but PSMNet and the classifiers were tried on a
    GPU."""
    loaders: int = 1
    """Threads that prepare the next steps; on a GPU processes."""
    minutes: float | None = None
    """Stop after this time, to be resumed.  Default: when all epochs are done."""
    checkpoint_minutes: float = 1.0
    """Time between checkpoints; a run that is killed loses at most as much, or a validation."""

    def __post_init__(self) -> None:
        times = (self.checkpoint_minutes, 0.0 if self.minutes is None else self.minutes)
        if self.loaders < 1 or not all(0 <= time < float("inf") for time in times):
            raise ConfigurationError(
                f"loaders are 1 or more, minutes finite and 0 or more, got {self}"
            )
