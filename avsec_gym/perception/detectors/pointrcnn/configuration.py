"""What a PointRCNN is made of: the points it sees, its layers, its sampling, and its presets."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.pointrcnn.bin_coding import BinCoding
from avsec_gym.perception.presets import preset_named

Range = tuple[float, float]
_FINE_CODING = BinCoding(1.5, 0.5, 9, is_fine=True)


@dataclass(frozen=True)
class PointView:
    """Which points of a scan the network sees: those in front, as many as it takes.

    Args:
        side: x from and to, metres in the camera frame.
        down: y from and to.
        forward: z from and to.
        points: How many.
        far: Farther points than this, in metres, are all taken, and the nearer ones by chance.
        most_far: Share of the points that may be far ones.

    Raises:
        ConfigurationError: A range is empty, or there are no points.
    """

    side: Range = (-40.0, 40.0)
    down: Range = (-1.0, 3.0)
    forward: Range = (0.0, 70.4)
    points: int = 16384
    far: float = 40.0
    most_far: float = 1.0

    def __post_init__(self) -> None:
        for start, stop in (self.side, self.down, self.forward):
            if start >= stop:
                raise ConfigurationError(f"there is nothing from {start} to {stop} m")
        if self.points < 1 or not 0 <= self.most_far <= 1:
            raise ConfigurationError(
                f"points are 1 or more, a share is in 0..1, got {self.points}, {self.most_far}"
            )


@dataclass(frozen=True)
class Level:
    """A `SetAbstraction`: points that remain, and the balls around them; see there."""

    count: int | None
    radii: tuple[float, ...]
    neighbours: tuple[int, ...]
    channels: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class ProposalRule:
    """Which points' boxes become proposals; the defaults are those of the published detector.

    Args:
        before: Boxes, best first, that enter the suppression.
        after: Proposals at most.
        most_overlap: Intersection over union of two of them.
        is_turned: Boxes are suppressed as they stand; otherwise, as published, as if all stood
            along x.
        near: Metres that separate near boxes from far ones, which are up to twice as far.
        near_share: The share of both numbers above that is for near boxes.
    """

    before: int = 9000
    after: int = 100
    most_overlap: float = 0.8
    is_turned: bool = False
    near: float = 40.0
    near_share: float = 0.7

    def __post_init__(self) -> None:
        if min(self.before, self.after) < 1 or not 0 <= self.most_overlap <= 1:
            raise ConfigurationError(f"proposals are 1 or more, an overlap in 0..1, got {self}")


@dataclass(frozen=True)
class RegionSampling:
    """How proposals for the second stage to learn from are chosen, by IoU with the truth in 3D.

    Args:
        regions: The number of regions of each scan.
        true_share: The share of them, at most, that lies on an object.
        hard_share: The share of the others that touches one.
        touching: Least overlap that counts as touching.
        least_box: Least overlap with an object whose box is learned.
        object: Overlap above which a proposal is an object.
        background: Overlap below which it is none; between the two, neither is learned.
        shakes: How often a proposal on an object is moved and turned at random, until it still
            overlaps it by `least_box`.
    """

    regions: int = 64
    true_share: float = 0.5
    hard_share: float = 0.8
    touching: float = 0.05
    least_box: float = 0.55
    object: float = 0.6
    background: float = 0.45
    shakes: int = 10


@dataclass(frozen=True)
class Refinement:
    """The second stage.

    Args:
        points: The number of points that are looked at in each proposal.
        margin: The margin about it, metres.
        inputs: Channels of the layers on coordinates, segmentation and distance.
        levels: The last one makes one of all points.
        head: Channels of the hidden layers of confidence and of boxes.
        is_normalised: Whether its layers are normalised, see `PointLayer`.
        coding: The coding of boxes.
    """

    points: int = 512
    margin: float = 1.0
    inputs: tuple[int, ...] = (128, 128)
    levels: tuple[Level, ...] = (
        Level(128, (0.2,), (64,), ((128, 128, 128),)),
        Level(32, (0.4,), (64,), ((128, 128, 256),)),
        Level(None, (100.0,), (64,), ((256, 256, 512),)),
    )
    head: tuple[int, ...] = (256, 256)
    is_normalised: bool = False
    coding: BinCoding = _FINE_CODING


@dataclass(frozen=True)
class PointRcnnConfiguration:
    """Every number of both stages; the defaults are those of the public code, as published.

    Args:
        view: The part of the scan that it reads.
        levels: The levels of the backbone, fine to coarse.
        propagation: Channels of the layers back up, fine to coarse; the first are those of points.
        head: Channels of the hidden layers of segmentation and of boxes.
        dropout: The dropout behind the first of them, in training.
        coding: The coding of the boxes that points propose.
        object_score: Points that score higher are marked for the second stage.
        proposals: The number of proposals in use.
        training_proposals: The number of proposals in training.
        refinement: The second stage.
        sampling: The points and proposals that it learns from.
        ignored_margin: Metres about an object in which a point is neither on it nor background.
        category: What is looked for.
        alike: Other classes that are learned as if they were this one.

    Raises:
        ConfigurationError: Numbers that do not fit each other.
    """

    view: PointView = PointView()
    levels: tuple[Level, ...] = (
        Level(4096, (0.1, 0.5), (16, 32), ((16, 16, 32), (32, 32, 64))),
        Level(1024, (0.5, 1.0), (16, 32), ((64, 64, 128), (64, 96, 128))),
        Level(256, (1.0, 2.0), (16, 32), ((128, 196, 256), (128, 196, 256))),
        Level(64, (2.0, 4.0), (16, 32), ((256, 256, 512), (256, 384, 512))),
    )
    propagation: tuple[tuple[int, ...], ...] = ((128, 128), (256, 256), (512, 512), (512, 512))
    head: tuple[int, ...] = (128,)
    dropout: float = 0.5
    coding: BinCoding = field(default_factory=BinCoding)
    object_score: float = 0.3
    proposals: ProposalRule = ProposalRule()
    training_proposals: ProposalRule = ProposalRule(after=512, most_overlap=0.85)
    refinement: Refinement = Refinement()
    sampling: RegionSampling = RegionSampling()
    ignored_margin: float = 0.2
    category: str = "Car"
    alike: tuple[str, ...] = ("Van",)

    def __post_init__(self) -> None:
        if len(self.levels) != len(self.propagation):
            raise ConfigurationError(
                f"{len(self.levels)} levels down and {len(self.propagation)} back up"
            )
        counts = [self.view.points, *(level.count or 0 for level in self.levels)]
        if counts != sorted(counts, reverse=True) or counts[-1] < 3:
            raise ConfigurationError(f"points become fewer, down to 3 or more, got {counts}")
        if self.refinement.levels[-1].count is not None:
            raise ConfigurationError("the last level of the refinement makes one of all points")

    @classmethod
    def preset(cls, name: str) -> PointRcnnConfiguration:
        """``default``, as published, or ``small``, for training and use on a CPU."""
        return preset_named("PointRCNN", name, _PRESETS)


_DEFAULT = PointRcnnConfiguration()
_SMALL = replace(
    _DEFAULT,
    # Beyond 45 m a car has fewer than the 25 pixels that KITTI asks of a moderate one.
    view=PointView((-25.0, 25.0), (-1.0, 3.0), (0.0, 50.0), 4096, far=20.0, most_far=0.5),
    # A quarter of the points: balls are larger.
    levels=(
        Level(1024, (0.3, 0.8), (8, 16), ((16, 16, 32), (16, 16, 32))),
        Level(256, (0.8, 1.6), (16, 16), ((32, 32, 64), (32, 48, 64))),
        Level(64, (1.6, 3.2), (16, 16), ((64, 96, 128), (64, 96, 128))),
        Level(16, (3.2, 6.4), (16, 16), ((128, 128, 256), (128, 192, 256))),
    ),
    propagation=((64, 64), (128, 128), (256, 256), (256, 256)),
    head=(64,),
    # Half of 64 channels leave too little to a short training.
    dropout=0.1,
    proposals=ProposalRule(1024, 48, 0.7, is_turned=True, near=25.0),
    training_proposals=ProposalRule(1024, 128, 0.8, is_turned=True, near=25.0),
    refinement=Refinement(
        128,
        inputs=(32, 64),
        levels=(
            Level(48, (0.4,), (16,), ((64, 64, 64),)),
            Level(16, (0.8,), (16,), ((64, 64, 128),)),
            Level(None, (100.0,), (16,), ((128, 128, 256),)),
        ),
        head=(128, 128),
        is_normalised=True,
    ),
    sampling=RegionSampling(32),
)
_PRESETS = {"default": _DEFAULT, "small": _SMALL}
