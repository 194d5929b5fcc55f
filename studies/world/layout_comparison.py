"""How closely the generated layouts match KITTI: statistics and distances."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.kitti.label_folders import read_label_folder
from avsec_gym.road_type import RoadType
from avsec_gym.world.layouts import generate_layouts
from studies.world.layout_quantities import CATEGORIES, OBSTACLES, QUANTITIES, Sample

GOAL_CENTRES = {"left": (15.0, 3.5), "straight": (15.0, 0.0), "right": (15.0, -3.5)}
"""Centres of the planner's goal regions in the ego frame, metres."""

_SCENARIO_FOLDERS = {
    RoadType.STREET: ("dynamic_label", "static_label", "nocar"),
    RoadType.HIGHWAY: ("road_dynamic_label",),
}


@dataclass(frozen=True)
class QuantityDistance:
    """How far generated and labelled frames are apart in a quantity."""

    kind: Literal["wasserstein", "variation"]
    unit: str
    """Unit of the distance; empty for a total variation."""
    distance: float
    yardstick: float
    """The same distance between two random halves of KITTI."""
    mean_ours: float
    mean_kitti: float


@dataclass(frozen=True)
class ObjectsPerFrame:
    """Mean number of objects in a frame, by category."""

    ours: Mapping[str, float]
    kitti: Mapping[str, float]


@dataclass(frozen=True)
class Sizes:
    """The 10, 50 and 90 % quantiles of a category's dimensions, metres."""

    height: list[float]
    width: list[float]
    length: list[float]


@dataclass(frozen=True)
class SizesByCategory:
    """Sizes of the categories that there are."""

    ours: Mapping[str, Sizes]
    kitti: Mapping[str, Sizes]


@dataclass(frozen=True)
class OccupiedGoals:
    """Share of frames in which an obstacle covers the centre of each goal region."""

    ours: Mapping[str, float]
    scenarios: Mapping[str, float] | None
    """Scenarios of the labelled driving-safety scenarios."""


@dataclass(frozen=True)
class LayoutSet:
    """Which layouts are compared."""

    count: int
    seed: int


@dataclass(frozen=True)
class LayoutComparison:
    """Everything in the figure and the table of `docs/layouts.md`."""

    layouts: LayoutSet
    kitti_frames: int
    quantities: Mapping[str, QuantityDistance]
    """Quantities by the names of `QUANTITIES`."""
    objects_per_frame: ObjectsPerFrame
    sizes: SizesByCategory
    occupied_goals: Mapping[str, OccupiedGoals]
    """Occupied goals by road type."""


def statistics(sample: Sample) -> dict[str, Floats]:
    """The samples of every quantity in `QUANTITIES`, by name."""
    return {name: quantity.measure(sample) for name, quantity in QUANTITIES.items()}


def compare(
    ours: Sample, kitti: Sample, splits: int = 10, seed: int = 0
) -> dict[str, QuantityDistance]:
    """The distance between two sets of frames in every quantity, with a yardstick.

    Args:
        ours: Generated frames.
        kitti: Labelled frames.
        splits: How many random halvings of `kitti` the yardstick averages.
        seed: Seed of the halvings.
    """
    mine, real = statistics(ours), statistics(kitti)
    rng = np.random.default_rng(seed)
    between_halves: dict[str, list[float]] = {name: [] for name in QUANTITIES}
    for _ in range(splits):
        order = rng.permutation(kitti.count)
        first, second = (statistics(kitti.pick(half)) for half in np.array_split(order, 2))
        for name, quantity in QUANTITIES.items():
            between_halves[name].append(quantity.distance(first[name], second[name]))
    return {
        name: QuantityDistance(
            kind=quantity.kind,
            unit=quantity.unit if quantity.kind == "wasserstein" else "",
            distance=round(quantity.distance(mine[name], real[name]), 4),
            yardstick=round(float(np.mean(between_halves[name])), 4),
            mean_ours=round(float(mine[name].mean()), 4),
            mean_kitti=round(float(real[name].mean()), 4),
        )
        for name, quantity in QUANTITIES.items()
    }


def objects_per_frame(sample: Sample) -> dict[str, float]:
    """Mean number of objects of each category in a frame."""
    return {
        name: round(float(sample.of_category([name]).sum()) / sample.count, 4)
        for name in CATEGORIES
    }


def sizes_by_category(sample: Sample) -> dict[str, Sizes]:
    """The sizes of the categories that a sample holds."""
    sizes = {}
    for name in CATEGORIES:
        dimensions = sample.boxes.dimensions[sample.of_category([name])]
        if len(dimensions):
            quantiles = np.quantile(dimensions, [0.1, 0.5, 0.9], axis=0).round(2).T.tolist()
            sizes[name] = Sizes(*quantiles)
    return sizes


def occupied_goals(sample: Sample) -> dict[str, float]:
    """Share of frames in which an obstacle covers the centre of each goal region."""
    obstacle = sample.of_category(OBSTACLES)
    boxes, frame = sample.boxes[obstacle], sample.frame[obstacle]
    x, y, heading = boxes.poses.T
    shares = {}
    for name, (goal_x, goal_y) in GOAL_CENTRES.items():
        along = np.cos(heading) * (goal_x - x) + np.sin(heading) * (goal_y - y)
        across = np.cos(heading) * (goal_y - y) - np.sin(heading) * (goal_x - x)
        covers = (np.abs(along) <= boxes.length / 2) & (np.abs(across) <= boxes.width / 2)
        shares[name] = round(len(np.unique(frame[covers])) / sample.count, 4)
    return shares


def read_scenarios(folder: Path) -> dict[RoadType, Sample]:
    """The labelled driving-safety scenarios by road type.

    Raises:
        DataError: One of its folders is missing or broken.
    """
    return {
        road_type: Sample.of(
            [boxes for name in names for boxes in read_label_folder(folder / name).values()]
        )
        for road_type, names in _SCENARIO_FOLDERS.items()
    }


def compare_with_kitti(
    kitti: Path, scenarios: Path | None = None, count: int = 7481, seed: int = 0
) -> tuple[LayoutComparison, Sample, Sample]:
    """Everything in the figure and the table of `docs/layouts.md`.

    Args:
        kitti: Root that holds ``training/label_2``, or ``object/training/label_2``.
        scenarios: Folder of the labelled driving-safety scenarios, for the goal regions.
        count: How many layouts are generated.
        seed: Seed of their set.

    Returns:
        The result, our sample and KITTI's.

    Raises:
        DataError: A folder is missing or broken.
    """
    nested = kitti / "object" / "training" / "label_2"
    folder = nested if nested.is_dir() else kitti / "training" / "label_2"
    real = Sample.of(list(read_label_folder(folder).values()))
    layouts = generate_layouts(count, seed)
    ours = Sample.of([layout.boxes for layout in layouts])
    labelled = {} if scenarios is None else read_scenarios(scenarios)
    goals = {}
    for road_type in RoadType:
        same = [layout.boxes for layout in layouts if layout.road_type is road_type]
        goals[road_type.value] = OccupiedGoals(
            ours=occupied_goals(Sample.of(same)),
            scenarios=occupied_goals(labelled[road_type]) if labelled else None,
        )
    result = LayoutComparison(
        layouts=LayoutSet(count, seed),
        kitti_frames=real.count,
        quantities=compare(ours, real),
        objects_per_frame=ObjectsPerFrame(objects_per_frame(ours), objects_per_frame(real)),
        sizes=SizesByCategory(sizes_by_category(ours), sizes_by_category(real)),
        occupied_goals=goals,
    )
    return result, ours, real
