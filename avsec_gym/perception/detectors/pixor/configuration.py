"""What a PIXOR is made of: the region it sees, its layers, its targets, and its presets."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.perception.presets import preset_named


@dataclass(frozen=True)
class BirdEyeRegion:
    """The space around the car that is seen from above, cut into cells.

    Rows run to the left and columns forward: a tensor is (..., rows, columns).

    Args:
        forward: x from and to, metres in the velodyne frame.
        left: y from and to.
        up: z from and to.
        cell: Side of a cell.
        slice: Height of a slice.

    Raises:
        ConfigurationError: A range is empty, or no multiple of its cells.
    """

    forward: tuple[float, float] = (0.0, 70.0)
    left: tuple[float, float] = (-40.0, 40.0)
    up: tuple[float, float] = (-2.5, 1.0)
    cell: float = 0.1
    slice: float = 0.1

    def __post_init__(self) -> None:
        for name, step in (("forward", self.cell), ("left", self.cell), ("up", self.slice)):
            start, stop = getattr(self, name)
            count = (stop - start) / step if step > 0 else 0.0
            if round(count) < 1 or abs(count - round(count)) > 1e-6:
                raise ConfigurationError(
                    f"{name} from {start} to {stop} m is not made of whole steps of {step} m"
                )

    @property
    def rows(self) -> int:
        """Cells from right to left."""
        return round((self.left[1] - self.left[0]) / self.cell)

    @property
    def columns(self) -> int:
        """Cells from near to far."""
        return round((self.forward[1] - self.forward[0]) / self.cell)

    @property
    def slices(self) -> int:
        """Layers from below."""
        return round((self.up[1] - self.up[0]) / self.slice)

    @property
    def shape(self) -> tuple[int, int, int]:
        """The shape of the network's input: a channel for each slice and one of reflectance."""
        return self.slices + 1, self.rows, self.columns


@dataclass(frozen=True)
class PixorConfiguration:
    """Every number of the network; the defaults are those of the public code, as published.

    Args:
        region: The region that it reads.
        stem: Channels of the first two convolutions.
        planes: Inner channels of the four stages of bottlenecks; the outer ones are four times
            as many.
        blocks: Bottlenecks of each stage.
        strides: The stride of each stage; the result has the resolution after the second one.
        laterals: Channels on the way back up, coarsest first; the last are those of the header.
        header_relu: A ReLU behind each convolution of the header, as in the paper; the public
            code has none.
        field_of_view: The angle about the x axis in which anything is found, degrees: that of the
            camera whose images the labels were made on.
        mean: The mean of the six values of a cell with an object (see `cell_coding`); the network
            learns them less the mean, over the deviation.
        deviation: The standard deviation of these values.
        focus: Exponent of the focal loss; 0: cross entropy, as in the public code.
        box_weight: The weight of the values in the loss.
        category: What is looked for.
        object_height: The object height, metres, given to every box, since the network finds no
            heights: the mean of KITTI's cars.

    Raises:
        ConfigurationError: Numbers that do not fit each other.
    """

    region: BirdEyeRegion = BirdEyeRegion()
    stem: int = 32
    planes: tuple[int, int, int, int] = (24, 48, 64, 96)
    blocks: tuple[int, int, int, int] = (3, 6, 6, 3)
    strides: tuple[int, int, int, int] = (2, 2, 2, 2)
    laterals: tuple[int, int, int] = (196, 128, 96)
    header_relu: bool = False
    field_of_view: float = 88.0
    mean: tuple[float, ...] = (0.008, 0.001, 0.202, 0.2, 0.43, 1.368)
    deviation: tuple[float, ...] = (0.866, 0.5, 0.954, 0.668, 0.09, 0.111)
    focus: float = 0.0
    box_weight: float = 0.1
    category: str = "Car"
    object_height: float = 1.53

    def __post_init__(self) -> None:
        if min(self.stem, *self.planes, *self.blocks, *self.laterals) < 1:
            raise ConfigurationError(f"channels and blocks are 1 or more, got {self}")
        if not set(self.strides) <= {1, 2}:
            raise ConfigurationError(f"a stage's stride is 1 or 2, got {self.strides}")
        if self.region.rows % self.stride or self.region.columns % self.stride:
            raise ConfigurationError(
                f"{self.region.rows} x {self.region.columns} cells are not a multiple of the"
                f" {self.stride} that become one"
            )
        if not (0 < self.field_of_view <= 180 and self.focus >= 0 and self.object_height > 0):
            raise ConfigurationError(
                "a field of view has up to 180 degrees, a focus is 0 or more, a height positive,"
                f" got {self.field_of_view}, {self.focus} and {self.object_height}"
            )
        if not (len(self.mean) == len(self.deviation) == 6 and min(self.deviation) > 0):
            raise ConfigurationError("mean and deviation are of six values each")

    @property
    def stride(self) -> int:
        """Cells of the input on a side of one of the output."""
        return self.strides[0] * self.strides[1]

    @property
    def output_cell(self) -> float:
        """Side of a cell of the output, metres."""
        return self.region.cell * self.stride

    @property
    def output_shape(self) -> tuple[int, int]:
        """Rows and columns of the output."""
        return self.region.rows // self.stride, self.region.columns // self.stride

    def corners(self) -> Floats:
        """The nearest, rightmost corner (x, y) of each cell of the output, shape (R, C, 2)."""
        rows, columns = self.output_shape
        x = self.region.forward[0] + self.output_cell * np.arange(columns)
        y = self.region.left[0] + self.output_cell * np.arange(rows)
        return np.stack(np.meshgrid(x, y), axis=-1)

    @classmethod
    def preset(cls, name: str) -> PixorConfiguration:
        """``default``, as published, or ``small``, for training and use on a CPU."""
        return preset_named("PIXOR", name, _PRESETS)


_DEFAULT = PixorConfiguration()
_SMALL = replace(
    _DEFAULT,
    # Beyond 45 m a car has fewer than the 25 pixels that KITTI asks of a moderate one.
    region=BirdEyeRegion((0.0, 44.8), (-20.0, 20.0), (-2.5, 1.0), 0.2, 0.25),
    stem=16,
    planes=(12, 20, 28, 40),
    blocks=(2, 3, 3, 2),
    # Cells twice as large, but the same 0.4 m of the output.
    strides=(2, 1, 2, 2),
    laterals=(96, 64, 48),
    header_relu=True,
    focus=2.0,
    box_weight=0.5,
)
_PRESETS = {"default": _DEFAULT, "small": _SMALL}
