"""The numbers of a YOLOv3: as published (`darknet53`), and a `small` one."""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.nn.resnet import Edges, Normalisation
from avsec_gym.perception.presets import preset_named

SCALES = 3
STRIDES = (8, 16, 32)
"""Pixels between neighbouring cells of the scales, finest first."""

Size = tuple[float, float]
"""Width and height, pixels."""


@dataclass(frozen=True)
class YoloConfiguration:
    """Every number that may differ between two networks of the same classes.

    Args:
        name: The name of the preset.
        categories: What is found.
        input_size: Height and width that images are resized to, pixels, multiples of 32; None
            resizes so that the longer side has `long_side` pixels, and rounds to such multiples.
        long_side: Length of the images' long side, pixels, see `input_size`.
        mean: The means of red, green and blue, grey levels 0..255.
        deviation: What the difference to the mean is divided by.
        stem_channels: Channels after the first convolution.
        stage_blocks: Residual blocks of the five stages, each of which halves the resolution.
        stage_channels: What comes out of the stages; the last three lead to the three scales.
        normalisation: The normalisation behind each convolution.
        edges: How convolutions see beyond the edge of their inputs.
        priors: Box sizes, a third of them for each scale, smallest first.
        prior_objectness: What an untrained network takes the probability of an object for.
        ignored_overlap: A box that overlaps an object more than this is not taught to be
            background, even if another one is responsible for the object.

    Raises:
        ConfigurationError: Numbers that do not go together, or an unknown preset.
    """

    name: str
    categories: tuple[str, ...] = ("Car",)
    input_size: tuple[int, int] | None = None
    long_side: int = 608
    mean: tuple[float, float, float] = (0.0, 0.0, 0.0)
    deviation: tuple[float, float, float] = (255.0, 255.0, 255.0)
    stem_channels: int = 32
    stage_blocks: tuple[int, int, int, int, int] = (1, 2, 8, 8, 4)
    stage_channels: tuple[int, int, int, int, int] = (64, 128, 256, 512, 1024)
    normalisation: Normalisation = "batch"
    edges: Edges = "zeros"
    priors: tuple[Size, ...] = (
        (10, 13), (16, 30), (33, 23), (30, 61), (62, 45), (59, 119), (116, 90), (156, 198),
        (373, 326),
    )  # fmt: skip
    prior_objectness: float = 0.01
    ignored_overlap: float = 0.5

    def __post_init__(self) -> None:
        if not self.categories:
            raise ConfigurationError("a detector finds at least one category, got none")
        if not self.priors or len(self.priors) % SCALES:
            raise ConfigurationError(
                f"priors are shared out among {SCALES} scales, got {len(self.priors)}"
            )
        if self.input_size is not None and any(side % STRIDES[-1] for side in self.input_size):
            raise ConfigurationError(
                f"sides of the input are multiples of {STRIDES[-1]}, got {self.input_size}"
            )
        if not (0 < self.prior_objectness < 1 and 0 <= self.ignored_overlap <= 1):
            raise ConfigurationError(
                "prior_objectness and ignored_overlap are shares, got "
                f"{self.prior_objectness} and {self.ignored_overlap}"
            )

    @classmethod
    def preset(cls, name: str) -> YoloConfiguration:
        """``darknet53`` (as published) or ``small``."""
        return preset_named("YOLOv3", name, PRESETS)

    @property
    def each(self) -> int:
        """Priors of a scale."""
        return len(self.priors) // SCALES

    @property
    def numbers(self) -> int:
        """The number of outputs of a box: four of place, objectness, and a logit of each class."""
        return 5 + len(self.categories)

    def size_for(self, height: int, width: int) -> tuple[int, int]:
        """Height and width that an image of a given size is resized to, pixels."""
        if self.input_size is not None:
            return self.input_size
        unit = self.long_side / (STRIDES[-1] * max(height, width))
        rows, columns = (max(round(side * unit), 1) for side in (height, width))
        return rows * STRIDES[-1], columns * STRIDES[-1]


_CAR_PRIORS = (
    (12, 10), (16, 14), (22, 17), (29, 24), (45, 20), (40, 32), (65, 41), (94, 66), (165, 92),
)  # fmt: skip

DARKNET53 = YoloConfiguration("darknet53")
"""The published one: 61.9 million parameters with the 80 categories of COCO."""

SMALL = YoloConfiguration(
    "small",
    input_size=(192, 640),
    mean=(95.0, 98.0, 95.0),
    deviation=(70.0, 70.0, 70.0),
    stem_channels=16,
    stage_blocks=(1, 1, 2, 2, 2),
    stage_channels=(32, 64, 96, 128, 256),
    normalisation="group",
    edges="replicate",
    priors=_CAR_PRIORS,
)
"""The same classes, narrower and shallower, for training from scratch on a CPU; its priors are
`prior_clusters` of the cars in 1,000 frames of the suite `mixed`."""

PRESETS = {preset.name: preset for preset in (DARKNET53, SMALL)}
