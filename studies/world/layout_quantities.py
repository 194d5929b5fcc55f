"""What is measured when layouts are compared with KITTI: samples of frames and quantities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, wrap_angle

OBSTACLES = ("Car", "Van", "Truck", "Misc")
PEOPLE = ("Pedestrian", "Person_sitting", "Cyclist")
CATEGORIES = ("Car", "Van", "Truck", "Misc", "Pedestrian", "Cyclist", "Person_sitting", "Tram")


@dataclass(frozen=True, eq=False)
class Sample:
    """The objects of many frames in one table."""

    boxes: Boxes3D
    frame: NDArray[np.int64]
    """Which frame each object belongs to, shape (N,), in 0 .. count - 1."""
    count: int
    """Number of frames, empty ones included."""

    @classmethod
    def of(cls, frames: Sequence[Boxes3D]) -> Sample:
        """Gather frames; 2D boxes, truncation and occlusion must be known."""
        frame = np.repeat(np.arange(len(frames)), [len(boxes) for boxes in frames])
        return cls(Boxes3D.concatenate(boxes for boxes in frames if len(boxes)), frame, len(frames))

    def pick(self, frames: NDArray[np.int64]) -> Sample:
        """Some of the frames, renumbered."""
        number = np.full(self.count, -1)
        number[frames] = np.arange(len(frames))
        chosen = number[self.frame] >= 0
        return Sample(self.boxes[chosen], number[self.frame][chosen], len(frames))

    def of_category(self, names: Sequence[str]) -> NDArray[np.bool_]:
        """Mask of the objects of some categories, shape (N,)."""
        return np.isin(self.boxes.category, names)


@dataclass(frozen=True)
class Quantity:
    """One statistic: how to take its samples from frames and how to compare them."""

    title: str
    unit: str
    measure: Callable[[Sample], Floats]
    edges: Floats
    """Edges of the histogram's bins."""
    kind: Literal["wasserstein", "variation"] = "wasserstein"
    """1-Wasserstein distance of the samples, in the unit, or total variation of the histograms."""

    def distance(self, first: Floats, second: Floats) -> float:
        """How far two sets of samples are apart; 0 is a perfect match."""
        if self.kind == "variation":
            counts = [np.histogram(samples, self.edges)[0] for samples in (first, second)]
            shares = [count / max(count.sum(), 1) for count in counts]
            return float(0.5 * np.abs(shares[0] - shares[1]).sum())
        levels = (np.arange(20_000) + 0.5) / 20_000
        return float(np.abs(np.quantile(first, levels) - np.quantile(second, levels)).mean())


def _objects(value: Callable[[Boxes3D], Floats], *names: str) -> Callable[[Sample], Floats]:
    """A value of every object of some categories."""
    return lambda sample: value(sample.boxes[sample.of_category(names)])


def _per_frame(*names: str) -> Callable[[Sample], Floats]:
    """How many objects of some categories each frame holds."""
    return lambda sample: np.bincount(
        sample.frame[sample.of_category(names)], minlength=sample.count
    ).astype(float)


def _image_height(boxes: Boxes3D) -> Floats:
    box2d = np.asarray(boxes.box2d)
    return np.asarray(box2d[:, 3] - box2d[:, 1])


def _cut_share(boxes: Boxes3D) -> Floats:
    shares = np.asarray(boxes.truncation)
    return shares[shares > 0]


def _categories(sample: Sample) -> Floats:
    """Index into `CATEGORIES` of every object."""
    order = {name: float(index) for index, name in enumerate(CATEGORIES)}
    return np.array([order.get(str(name), -1.0) for name in sample.boxes.category])


def _edges(low: float, high: float, step: float) -> Floats:
    return np.arange(low, high + step / 2, step)


_Z = _objects(lambda boxes: boxes.location[:, 2], *OBSTACLES)
_X = _objects(lambda boxes: boxes.location[:, 0], *OBSTACLES)
_YAW = _objects(lambda boxes: wrap_angle(boxes.rotation_y), *OBSTACLES)
_FOLDED_YAW = _objects(lambda boxes: boxes.rotation_y % np.pi, *OBSTACLES)
_OCCLUSION = _objects(lambda boxes: np.asarray(boxes.occlusion), *OBSTACLES)
_PEOPLE_Z = _objects(lambda boxes: boxes.location[:, 2], *PEOPLE)
_PEOPLE_X = _objects(lambda boxes: boxes.location[:, 0], *PEOPLE)
_PI = np.pi

QUANTITIES: dict[str, Quantity] = {
    "cars_per_frame": Quantity("Cars per frame", "", _per_frame("Car"), _edges(-0.5, 20.5, 1)),
    "people_per_frame": Quantity(
        "People per frame", "", _per_frame(*PEOPLE), _edges(-0.5, 10.5, 1)
    ),
    "category": Quantity("Category", "", _categories, _edges(-0.5, 7.5, 1), "variation"),
    "occlusion": Quantity("Occlusion level", "", _OCCLUSION, _edges(-0.5, 3.5, 1), "variation"),
    "distance": Quantity("Distance z", "m", _Z, _edges(0, 85, 2.5)),
    "lateral": Quantity("Lateral position x", "m", _X, _edges(-25, 25, 1)),
    "heading": Quantity("Heading", "rad", _YAW, _edges(-_PI, _PI, _PI / 18), "variation"),
    "folded_heading": Quantity(
        "Heading, folded", "rad", _FOLDED_YAW, _edges(0, _PI, _PI / 36), "variation"
    ),
    "car_height": Quantity(
        "Height of cars",
        "m",
        _objects(lambda boxes: boxes.dimensions[:, 0], "Car"),
        _edges(1.2, 2.2, 0.04),
    ),
    "car_width": Quantity(
        "Width of cars",
        "m",
        _objects(lambda boxes: boxes.dimensions[:, 1], "Car"),
        _edges(1.2, 2.1, 0.04),
    ),
    "car_length": Quantity(
        "Length of cars",
        "m",
        _objects(lambda boxes: boxes.dimensions[:, 2], "Car"),
        _edges(2.4, 5.4, 0.12),
    ),
    "image_height": Quantity(
        "Height in the image", "px", _objects(_image_height, *OBSTACLES), _edges(0, 375, 12.5)
    ),
    "truncated_share": Quantity(
        "Truncated at all",
        "",
        _objects(lambda boxes: (np.asarray(boxes.truncation) > 0).astype(float), *OBSTACLES),
        _edges(-0.5, 1.5, 1),
        "variation",
    ),
    "truncation": Quantity(
        "Truncation where cut", "", _objects(_cut_share, *OBSTACLES), _edges(0, 1, 0.05)
    ),
    "people_distance": Quantity("Distance z of people", "m", _PEOPLE_Z, _edges(0, 70, 2.5)),
    "people_lateral": Quantity("Lateral position x of people", "m", _PEOPLE_X, _edges(-20, 20, 1)),
}
"""Everything that is compared; vehicles are the obstacle classes unless the title names more."""
