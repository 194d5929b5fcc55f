"""The numbers of a Faster R-CNN: as widely used (`resnet50`, `resnet101`), and a `small` one."""

from __future__ import annotations

from dataclasses import dataclass, replace

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.nn.region_counts import ProposalCount
from avsec_gym.perception.nn.resnet import Edges, Normalisation
from avsec_gym.perception.presets import preset_named

_TRAINING_PROPOSALS, _TEST_PROPOSALS = ProposalCount(12000, 2000), ProposalCount(6000, 1000)


@dataclass(frozen=True)
class FasterRcnnConfiguration:
    """Every number that may differ between two networks of the same classes.

    Args:
        name: The name of the preset.
        categories: What is found, the background left out.
        input_size: Height and width that images are resized to, pixels; None resizes so that the
            shorter side has `short_side` pixels, or the longer one `long_side`.
        short_side: Length of the images' short side, pixels, see `input_size`.
        long_side: Greatest length of the images' long side, pixels, see `input_size`.
        mean: The means of red, green and blue, grey levels 0..255.
        deviation: What the difference to the mean is divided by.
        stem_channels: Channels after the first convolution.
        stage_blocks: Bottlenecks of the four residual stages.
        stage_channels: Inner channels of their bottlenecks; four times as many come out.
        normalisation: Batch statistics that never change, that are learned, or groups of channels.
        edges: How the body's convolutions see beyond the edge of their inputs.
        frozen_stages: How many parts of the body are not trained, counted from the stem.
        pyramid_channels: Channels of each level P2..P6.
        anchor_sizes: Square root of the anchors' area at P2..P6, pixels.
        anchor_ratios: Width over height.
        anchor_scales: The scales of `anchor_sizes` at each level.
        training_proposals: Numbers of proposals in training.
        test_proposals: Numbers of proposals in use.
        proposal_overlap: Proposals that overlap more than this suppress each other.
        least_side: Proposals that are narrower or lower are dropped, pixels.
        canonical_size: Regions of this size (square root of the area, pixels) belong to P4.
        sampling_ratio: Samples along an axis of a bin in ROI align; 0 adapts to the bin.
        box_channels: Channels of the box head's two hidden layers.
        he_initialisation: Start hidden layers after He et al., and residual blocks as identities,
            for training from scratch; else with small normal weights, for a pretrained body.

    Raises:
        ConfigurationError: Numbers that do not go together, or an unknown preset.
    """

    name: str
    categories: tuple[str, ...] = ("Car",)
    input_size: tuple[int, int] | None = None
    short_side: int = 800
    long_side: int = 1333
    mean: tuple[float, float, float] = (123.675, 116.28, 103.53)
    deviation: tuple[float, float, float] = (58.395, 57.12, 57.375)
    stem_channels: int = 64
    stage_blocks: tuple[int, int, int, int] = (3, 4, 6, 3)
    stage_channels: tuple[int, int, int, int] = (64, 128, 256, 512)
    normalisation: Normalisation = "frozen_batch"
    edges: Edges = "zeros"
    frozen_stages: int = 2
    pyramid_channels: int = 256
    anchor_sizes: tuple[float, float, float, float, float] = (32, 64, 128, 256, 512)
    anchor_ratios: tuple[float, ...] = (0.5, 1.0, 2.0)
    anchor_scales: tuple[float, ...] = (1.0,)
    training_proposals: ProposalCount = _TRAINING_PROPOSALS
    test_proposals: ProposalCount = _TEST_PROPOSALS
    proposal_overlap: float = 0.7
    least_side: float = 0.0
    canonical_size: float = 224.0
    sampling_ratio: int = 2
    box_channels: int = 1024
    he_initialisation: bool = False

    def __post_init__(self) -> None:
        if not self.categories:
            raise ConfigurationError("a detector finds at least one category, got none")
        if not 0 <= self.frozen_stages <= 5:
            raise ConfigurationError(f"there are 5 stages to freeze, got {self.frozen_stages}")

    @classmethod
    def preset(cls, name: str) -> FasterRcnnConfiguration:
        """``resnet50``, ``resnet101`` (the thesis' body) or ``small``."""
        return preset_named("Faster R-CNN", name, PRESETS)

    @property
    def classes(self) -> int:
        """Outputs of the classifier: the background is class 0."""
        return 1 + len(self.categories)

    def size_for(self, height: int, width: int) -> tuple[int, int]:
        """Height and width that an image of a given size is resized to, pixels."""
        if self.input_size is not None:
            return self.input_size
        short, long = sorted((height, width))
        scale = min(self.short_side / short, self.long_side / long)
        return round(height * scale), round(width * scale)


RESNET50 = FasterRcnnConfiguration("resnet50")
"""41.8 million parameters with 90 categories."""

RESNET101 = replace(RESNET50, name="resnet101", stage_blocks=(3, 4, 23, 3))

SMALL = FasterRcnnConfiguration(
    "small",
    input_size=(192, 640),
    mean=(95.0, 98.0, 95.0),
    deviation=(70.0, 70.0, 70.0),
    stem_channels=32,
    stage_blocks=(2, 3, 4, 2),
    stage_channels=(24, 48, 96, 128),
    normalisation="group",
    edges="replicate",
    frozen_stages=0,
    pyramid_channels=64,
    anchor_sizes=(12, 24, 48, 96, 192),
    # Cars are wider than high, and wider still from the side.
    anchor_ratios=(1.0, 1.6, 2.4),
    anchor_scales=(1.0, 2**0.5),
    training_proposals=ProposalCount(1000, 300),
    test_proposals=ProposalCount(500, 100),
    least_side=3.0,
    canonical_size=112.0,
    box_channels=256,
    he_initialisation=True,
)
"""The same classes, narrower and shallower, for training from scratch on a CPU."""

PRESETS = {preset.name: preset for preset in (RESNET50, RESNET101, SMALL)}
