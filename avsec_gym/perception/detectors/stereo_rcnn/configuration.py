"""The numbers of a Stereo R-CNN: as published (`resnet101`), and one that a CPU can train."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.stereo_rcnn.alignment import (
    MEASURED,
    PUBLISHED,
    Alignment,
)
from avsec_gym.perception.detectors.stereo_rcnn.decoding_rule import StereoRcnnDecodingRule
from avsec_gym.perception.nn.region_counts import ProposalCount
from avsec_gym.perception.nn.resnet import Edges, Normalisation
from avsec_gym.perception.presets import preset_named

_TRAINING_PROPOSALS, _TEST_PROPOSALS = ProposalCount(12000, 2000), ProposalCount(6000, 300)


@dataclass(frozen=True)
class StereoRcnnConfiguration:
    """Every number that may differ between two networks of the same classes.

    Args:
        name: The name of the preset.
        categories: What is found, the background left out.
        input_size: Height and width that images are resized to, pixels; None resizes so that the
            shorter side has `short_side` pixels.
        short_side: Length of the images' short side, pixels, see `input_size`.
        blue_first: Whether channels go in as blue, green, red; else red, green, blue.
        mean: The mean of each channel as it goes in, grey levels 0..255.
        deviation: What the difference to the mean is divided by.
        stem_channels: Channels after the first convolution.
        stage_blocks: Bottlenecks of the four residual stages.
        stage_channels: Inner channels of their bottlenecks; four times as many come out.
        normalisation: Batch statistics that never change, that are learned, or groups of channels.
        edges: How the body's convolutions see beyond the edge of their inputs: ``zeros`` as
            published, or the nearest value (``replicate``).  Zeros make the outermost cells unlike
            all others; in a network with normalised groups, trained from scratch with them, only
            those cells of the deep layers still responded.
        frozen_stages: How many parts are not trained, counted from the stem.
        pyramid_channels: Channels of each level P2..P6.
        rpn_channels: Channels of the proposal network's hidden layer, for each view.
        anchor_sizes: Square root of the anchors' area at P2..P6, pixels.
        anchor_ratios: Height over width would be 1 / ratio.
        crossed_scores: Rank proposals by the published code's reading of the class map, which
            pairs the channels of different anchors; else by the pairs that the loss trains.
        exact_boxes: Decoding undoes encoding; the published code's boxes come out of it a pixel
            wider and higher.
        training_proposals: Numbers of proposals in training.
        test_proposals: Numbers of proposals in use.
        proposal_overlap: Proposals that overlap more than this suppress each other.
        least_side: Proposals that are narrower or lower in either view are dropped, pixels; the
            published code keeps them, empty ones as well.
        canonical_size: Regions of this size (square root of the area, pixels) belong to P4.
        sampling_ratio: Samples along an axis of a bin in ROI align; 0 adapts to the bin.
        box_channels: Channels of the box head's two hidden layers.
        box_dropout: Share of them that training drops.
        keypoint_channels: Channels of the keypoint head.
        keypoint_convolutions: 3x3 convolutions of the keypoint head.
        background_sizes: Whether the background, too, is taught a size, that of the mean car, as
            in the published code.  Trained from scratch, hidden features of regions of the sky grew
            a hundredfold, and the gradient of this term with them.
        he_initialisation: Start hidden layers after He et al., and residual blocks as identities,
            for training from scratch; else with the small normal weights of the published code,
            for a pretrained body.
        fit: Whether a number of each region estimates how well its box fits: the intersection over
            union in space with the object.
        rule: The rule by which regions become boxes.
        alignment: How dense alignment searches depths.

    Raises:
        ConfigurationError: Numbers that do not go together, or an unknown preset.
    """

    name: str
    categories: tuple[str, ...] = ("Car",)
    input_size: tuple[int, int] | None = None
    short_side: int = 600
    blue_first: bool = True
    mean: tuple[float, float, float] = (102.9801, 115.9465, 122.7717)
    deviation: tuple[float, float, float] = (1.0, 1.0, 1.0)
    stem_channels: int = 64
    stage_blocks: tuple[int, int, int, int] = (3, 4, 23, 3)
    stage_channels: tuple[int, int, int, int] = (64, 128, 256, 512)
    normalisation: Normalisation = "frozen_batch"
    edges: Edges = "zeros"
    frozen_stages: int = 2
    pyramid_channels: int = 256
    rpn_channels: int = 512
    anchor_sizes: tuple[float, float, float, float, float] = (32, 64, 128, 256, 512)
    anchor_ratios: tuple[float, ...] = (0.5, 1.0, 2.0)
    crossed_scores: bool = True
    exact_boxes: bool = False
    training_proposals: ProposalCount = _TRAINING_PROPOSALS
    test_proposals: ProposalCount = _TEST_PROPOSALS
    proposal_overlap: float = 0.7
    least_side: float = 0.0
    canonical_size: float = 224.0
    sampling_ratio: int = 0
    box_channels: int = 2048
    box_dropout: float = 0.2
    keypoint_channels: int = 256
    keypoint_convolutions: int = 6
    background_sizes: bool = True
    he_initialisation: bool = False
    fit: bool = False
    rule: StereoRcnnDecodingRule = field(default_factory=StereoRcnnDecodingRule)
    alignment: Alignment = PUBLISHED

    def __post_init__(self) -> None:
        if not self.categories:
            raise ConfigurationError("a detector finds at least one category, got none")
        if self.crossed_scores and len(self.anchor_ratios) % 2 == 0:
            raise ConfigurationError(
                "crossed scores need an odd number of anchor ratios (else background channels rank"
                f" anchors), got {self.anchor_ratios}"
            )
        if not 0 <= self.frozen_stages <= 5:
            raise ConfigurationError(f"there are 5 stages to freeze, got {self.frozen_stages}")
        if self.rule.fit_share > 0 and not self.fit:
            raise ConfigurationError("a score has a share of the fit only where it is predicted")

    @classmethod
    def preset(cls, name: str) -> StereoRcnnConfiguration:
        """``resnet101`` (as published) or ``small``."""
        return preset_named("Stereo R-CNN", name, PRESETS)

    @property
    def classes(self) -> int:
        """Outputs of the classifier: the background is class 0."""
        return 1 + len(self.categories)

    def size_for(self, height: int, width: int) -> tuple[int, int]:
        """Height and width that an image of a given size is resized to, pixels."""
        if self.input_size is not None:
            return self.input_size
        scale = self.short_side / min(height, width)
        return round(height * scale), round(width * scale)


RESNET101 = StereoRcnnConfiguration("resnet101")
"""The published one: 105,891,446 parameters."""

FIRST_SMALL = StereoRcnnConfiguration(
    "small",
    input_size=(192, 640),
    blue_first=False,
    mean=(95.0, 98.0, 95.0),
    deviation=(70.0, 70.0, 70.0),
    stem_channels=32,
    stage_blocks=(2, 3, 4, 2),
    stage_channels=(24, 48, 96, 128),
    normalisation="group",
    edges="replicate",
    frozen_stages=0,
    pyramid_channels=64,
    rpn_channels=64,
    anchor_sizes=(12, 24, 48, 96, 192),
    crossed_scores=False,
    exact_boxes=True,
    training_proposals=ProposalCount(1000, 300),
    test_proposals=ProposalCount(500, 64),
    sampling_ratio=2,
    box_channels=256,
    box_dropout=0.0,
    keypoint_channels=64,
    keypoint_convolutions=3,
    least_side=3.0,
    background_sizes=False,
    he_initialisation=True,
    alignment=MEASURED,
)
"""The small one of the first edition, 2026, for the weights that were trained for it."""

SMALL = replace(
    FIRST_SMALL,
    fit=True,
    rule=StereoRcnnDecodingRule(fit_share=0.5),
    # By average precision on the validation frames: 30 and 40 are alike, at 60 it is as without.
    alignment=replace(MEASURED, most_difference=40.0),
)
"""The same classes, narrower and shallower, for training from scratch on a CPU."""

PRESETS = {preset.name: preset for preset in (RESNET101, SMALL)}
