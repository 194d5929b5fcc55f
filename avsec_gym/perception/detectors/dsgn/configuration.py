"""What a DSGN is made of: every number and switch of the architecture, and its presets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.perception.nn.pyramid_pooling import FeatureConfiguration
from avsec_gym.perception.presets import preset_named


@dataclass(frozen=True)
class DepthScale:
    """Depths in metres, from far to near, their steps equal in ``depth ** power``.

    A power of 1 spaces them equally in metres, -1 in disparity, and 0, between the two, in the
    logarithm.
    """

    far: float
    near: float
    count: int
    power: int = 1

    def __post_init__(self) -> None:
        if not self.far > self.near > 0 or self.count < 2:
            raise ConfigurationError(f"a depth scale falls from far to near > 0, got {self}")

    def values(self) -> Floats:
        """The depths, shape (count,)."""
        steps = np.linspace(self._warped(self.far), self._warped(self.near), self.count)
        return np.exp(steps) if self.power == 0 else steps ** (1 / self.power)

    def position(self, depth: Floats) -> Floats:
        """How far along the scale depths lie: -1 at the far end, 1 at the near one."""
        start, stop = self._warped(self.far), self._warped(self.near)
        return 2 * (self._warped(depth) - start) / (stop - start) - 1

    def _warped(self, depth: Floats | float) -> Floats:
        return np.asarray(np.log(depth) if self.power == 0 else np.power(depth, self.power))


@dataclass(frozen=True)
class GridAxis:
    """Cells of equal size between two coordinates (metres, camera frame); may run backwards."""

    start: float
    stop: float
    cells: int

    def centres(self) -> Floats:
        """Shape (cells,), metres, from start to stop."""
        return self.start + (np.arange(self.cells) + 0.5) * (self.stop - self.start) / self.cells


@dataclass(frozen=True)
class WorldGrid:
    """The voxels of the camera frame that are searched for objects; tensors are (z, y, x)."""

    x: GridAxis
    y: GridAxis
    z: GridAxis


@dataclass(frozen=True)
class Anchor:
    """The box that a class starts from, standing at every cell of the bird's-eye view (metres)."""

    category: str
    centre_y: float
    """Of the box's centre, in the camera frame: y points down."""
    height: float
    width: float
    length: float


PEDESTRIAN = Anchor("Pedestrian", 0.74, 1.73, 0.6, 0.8)
CAR = Anchor("Car", 0.825, 1.56, 1.6, 3.9)
CYCLIST = Anchor("Cyclist", 0.74, 1.73, 0.6, 1.76)


FEATURES = FeatureConfiguration(
    first=64,
    stages=((32, 3), (64, 6), (128, 12), (192, 4)),
    joined=(2, 3, 4),
    aligned_corners=True,
    matching=(256, 32),
    semantic=(64, 32),
    groups=32,
)


@dataclass(frozen=True)
class DsgnConfiguration:
    """The architecture; the defaults are those of the original car detector.

    Raises:
        ConfigurationError: Numbers that do not fit together, or an unknown preset.
    """

    input_size: tuple[int, int] | None = None
    """Height and width that images are scaled to; None leaves them as they are."""
    padded_size: tuple[int, int] = (384, 1248)
    """Zeros are added at the right and below up to this size; multiples of 16."""
    features: FeatureConfiguration = FEATURES
    """Of the images.  The semantic head also decides whether its features enter the world grid."""
    groups: int = 32
    """Of normalised channels behind the features, see `normalisation`."""

    planes: DepthScale = DepthScale(40.0, 2.4, 48)
    """Of the plane-sweep volume."""
    bins: DepthScale = DepthScale(40.2, 2.0, 192)
    """Of the softmax over depth: the planes' costs are interpolated."""
    sampled: DepthScale = DepthScale(40.4, 2.0, 2)
    """Which depths lie at the centres of the first and last plane (or bin) where the world grid
    samples the volume; the original takes the grid's ends, 0.4 m off."""
    full_depth: bool = True
    """Costs enlarged to the image before the softmax; otherwise the expected depth is."""
    correlation_groups: int = 0
    """Of matching features whose products fill the volume; 0 fills it with both features."""
    volume_channels: int = 64
    volume_begins_with_hourglass: bool = False
    """One hourglass in the place of four convolutions and an hourglass on a residual."""
    volume_residual: bool = False
    """Whether what comes into that one hourglass is added to what it makes."""
    cost_kernel: int = 3
    """Of the two convolutions that make a cost of each plane."""

    grid: WorldGrid = WorldGrid(
        GridAxis(-30.4, 30.4, 304), GridAxis(3.0, -1.0, 20), GridAxis(40.4, 2.0, 192)
    )
    aligned_corners: bool = True
    """Of every sampling by the world grid: -1 and 1 are the centres of the outermost cells (torch
    below 1.3, with which the published weights were trained) or their outer edges."""
    exact_pixels: bool = False
    """Feature i stands at pixel 4 i, where its convolutions centre it; otherwise the features are
    stretched so that the last one stands at the last pixel, up to 3 pixels off."""
    costs_in_grid: bool = True
    """Whether the planes' costs, without gradient, enter the world grid."""
    grid_channels: int = 64
    grid_kernel: int = 3
    grid_hourglass: bool = True
    pooled_heights: int = 4
    """Layers of the grid that one mean over y takes in."""
    view_channels: int = 128
    """Of the bird's-eye view."""

    tower_length: int = 1
    """Convolutions in each of the two halves of a tower."""
    anchors: tuple[Anchor, ...] = (PEDESTRIAN, CAR, CYCLIST)
    angles: int = 4
    """Anchors of each class, evenly turned."""

    def __post_init__(self) -> None:
        if self.grid.y.cells % self.pooled_heights:
            raise ConfigurationError(
                f"{self.grid.y.cells} layers of the grid are not a multiple of the"
                f" {self.pooled_heights} that are pooled"
            )
        pair = self.correlation_groups or 2 * self.features.matching[1]
        if self.volume_begins_with_hourglass and pair != self.volume_channels:
            raise ConfigurationError(
                f"an hourglass keeps its channels, yet {pair} come in and"
                f" volume_channels is {self.volume_channels}"
            )
        if self.correlation_groups and self.features.matching[1] % self.correlation_groups:
            raise ConfigurationError(
                f"{self.features.matching[1]} features do not make {self.correlation_groups} groups"
            )
        sizes = {
            "padded_size": (*self.padded_size, 16),
            "planes": (self.planes.count, 4),
            "the grid's cells along x and z": (self.grid.x.cells, self.grid.z.cells, 4),
        }
        if self.grid_hourglass:
            sizes["the grid's cells along y"] = (self.grid.y.cells, 4)
        for name, (*counts, divisor) in sizes.items():
            if any(count <= 0 or count % divisor for count in counts):
                raise ConfigurationError(f"{name}: {counts} must be multiples of {divisor}")
        if self.input_size is not None and (
            self.input_size[0] > self.padded_size[0] or self.input_size[1] > self.padded_size[1]
        ):
            raise ConfigurationError(
                f"images of {self.input_size} do not fit into {self.padded_size}"
            )

    @classmethod
    def preset(cls, name: str) -> DsgnConfiguration:
        """See `avsec_gym.perception.detectors.dsgn.presets`."""
        from avsec_gym.perception.detectors.dsgn.presets import PRESETS

        return preset_named("DSGN", name, PRESETS)
