"""Labels of rendered frames against KITTI's: how many, how far, how turned, how hidden.

Unlike those of `layout_statistics`, these labels come from what the camera sees.

Run ``python -m studies.world.labels --frames 300 --kitti ROOT``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.kitti.label_folders import read_label_folder
from avsec_gym.world.capture import Capture
from avsec_gym.world.posed_scenes import PosedScene
from studies.world.command import command, measure_one
from studies.world.frames import quantiles
from studies.world.layout_comparison import ObjectsPerFrame, objects_per_frame
from studies.world.layout_quantities import (
    CATEGORIES,
    OBSTACLES,
    QUANTITIES,
    Quantity,
    Sample,
)

_NUMBERS = ("location", "dimensions", "rotation_y", "box2d", "truncation", "occlusion", "alpha")


@dataclass(frozen=True)
class LabelRow:
    """The labels of a rendered frame as lists; see `Boxes3D`."""

    location: list[list[float]]
    dimensions: list[list[float]]
    rotation_y: list[float]
    box2d: list[list[float]]
    truncation: list[float]
    occlusion: list[float]
    alpha: list[float]
    category: list[str]


@dataclass(frozen=True)
class LabelQuantity:
    """How far rendered and real labels are apart in a quantity."""

    title: str
    kind: Literal["wasserstein", "variation"]
    unit: str
    """Unit of the distance; empty for a total variation."""
    distance: float | None
    yardstick: float | None
    """The distance that chance alone makes: of random real frames, as many as rendered ones."""
    mean_ours: float | None
    mean_kitti: float | None
    edges: list[float]
    """Edges of the histograms."""
    ours: list[float]
    """The share in each bin."""
    kitti: list[float]


@dataclass(frozen=True)
class LabelComparison:
    """Everything that is compared."""

    frames: int
    kitti_frames: int
    categories: list[str]
    objects_per_frame: ObjectsPerFrame
    quantities: Mapping[str, LabelQuantity]
    """Quantities by the names of `COMPARED`."""


def measure(posed: PosedScene, capture: Capture) -> LabelRow:
    """The labels as lists."""
    boxes = capture.labels.boxes
    numbers = {name: np.round(getattr(boxes, name), 4).tolist() for name in _NUMBERS}
    return LabelRow(**numbers, category=boxes.category.tolist())


def boxes_of(row: LabelRow) -> Boxes3D:
    """The inverse of `measure`."""
    count = len(row.category)
    tails = {"location": (3,), "dimensions": (3,), "box2d": (4,)}
    columns = {
        name: np.asarray(getattr(row, name), float).reshape(count, *tails.get(name, ()))
        for name in _NUMBERS
    }
    return Boxes3D(**columns, score=np.ones(count), category=np.asarray(row.category, np.str_))


def real_sample(kitti: Path) -> Sample:
    """All labels of the object benchmark.

    Raises:
        DataError: The folder is missing, or a label is broken.
    """
    nested = kitti / "object"
    folder = (nested if nested.is_dir() else kitti) / "training" / "label_2"
    return Sample.of(list(read_label_folder(folder).values()))


def _observed(sample: Sample) -> Floats:
    return wrap_angle(np.asarray(sample.boxes.alpha)[sample.of_category(OBSTACLES)])


COMPARED: dict[str, Quantity] = {
    name: QUANTITIES[name]
    for name in (
        "cars_per_frame",
        "people_per_frame",
        "category",
        "occlusion",
        "distance",
        "lateral",
        "heading",
        "image_height",
        "truncated_share",
        "truncation",
        "people_distance",
    )
} | {
    "alpha": Quantity(
        "Observation angle",
        "rad",
        _observed,
        np.arange(-np.pi, np.pi + 0.01, np.pi / 18),
        "variation",
    )
}
"""What is compared; of vehicles (car, van, truck, misc) unless the title states otherwise."""


def compare(ours: Sample, kitti: Sample, splits: int = 10) -> dict[str, LabelQuantity]:
    """Distances in every quantity, beside the distances that chance alone makes.

    Args:
        ours: Rendered frames.
        kitti: Labelled frames.
        splits: How many random parts of KITTI, as many frames as ours, the yardstick averages.
    """
    rng = np.random.default_rng(0)
    size = min(ours.count, kitti.count // 2)
    parts = [kitti.pick(rng.choice(kitti.count, size, replace=False)) for _ in range(splits)]
    result = {}
    for name, quantity in COMPARED.items():
        mine, real = quantity.measure(ours), quantity.measure(kitti)
        by_chance = [_distance(quantity, quantity.measure(part), real) for part in parts]
        result[name] = LabelQuantity(
            title=quantity.title,
            kind=quantity.kind,
            unit=quantity.unit if quantity.kind == "wasserstein" else "",
            distance=_distance(quantity, mine, real),
            yardstick=quantiles(by_chance).mean,
            mean_ours=quantiles(mine.tolist()).mean,
            mean_kitti=quantiles(real.tolist()).mean,
            edges=quantity.edges.tolist(),
            ours=_shares(mine, quantity),
            kitti=_shares(real, quantity),
        )
    return result


def _distance(quantity: Quantity, first: Floats, second: Floats) -> float | None:
    """None where there is nothing to compare, such as truncations of frames without any."""
    return quantity.distance(first, second) if len(first) and len(second) else None


def _shares(samples: Floats, quantity: Quantity) -> list[float]:
    counts = np.histogram(samples, quantity.edges)[0]
    return (counts / max(len(samples), 1)).round(5).tolist()


def summary(rows: Sequence[LabelRow], kitti: Sample) -> LabelComparison:
    """Everything that is compared.

    Args:
        rows: The rows of `measure`.
        kitti: The result of `real_sample`.
    """
    ours = Sample.of([boxes_of(row) for row in rows])
    return LabelComparison(
        frames=ours.count,
        kitti_frames=kitti.count,
        categories=list(CATEGORIES),
        objects_per_frame=ObjectsPerFrame(objects_per_frame(ours), objects_per_frame(kitti)),
        quantities=compare(ours, kitti),
    )


def required(kitti: Path | None) -> Path:
    """The folder of the real frames.

    Raises:
        ConfigurationError: None is named.
    """
    if kitti is None:
        raise ConfigurationError("this is compared with real frames: name their folder by --kitti")
    return kitti


def run(options: argparse.Namespace) -> LabelComparison:
    """Measure and compare.

    Raises:
        ConfigurationError: There are no real labels.
        DataError: A label is broken.
    """
    kitti = real_sample(required(options.kitti))
    return summary(measure_one(options, measure, images=False), kitti)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write JSON; returns the exit code."""
    return command(__doc__, arguments, run, frames=300)


if __name__ == "__main__":
    sys.exit(main())
