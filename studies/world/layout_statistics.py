"""How closely the generated layouts match KITTI: statistics, distances, one figure.

Run ``python -m studies.world.layout_statistics --kitti ROOT --scenarios DIR``.
"""

from __future__ import annotations

import argparse
import json
import logging
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.errors import AvsecError
from avsec_gym.geometry import Floats
from avsec_gym.kitti.label_folders import read_label_folder
from avsec_gym.road_type import RoadType
from avsec_gym.world.layouts import generate_layouts
from studies.world.layout_quantities import CATEGORIES, OBSTACLES, QUANTITIES, Sample

GOAL_CENTRES = {"left": (15.0, 3.5), "straight": (15.0, 0.0), "right": (15.0, -3.5)}
"""Centres of the planner's goal regions in the ego frame, metres."""

_LOG = logging.getLogger(__name__)
_SCENARIO_FOLDERS = {
    RoadType.STREET: ("dynamic_label", "static_label", "nocar"),
    RoadType.HIGHWAY: ("road_dynamic_label",),
}


def statistics(sample: Sample) -> dict[str, Floats]:
    """The samples of every quantity in `QUANTITIES`, by name."""
    return {name: quantity.measure(sample) for name, quantity in QUANTITIES.items()}


def compare(ours: Sample, kitti: Sample, splits: int = 10, seed: int = 0) -> dict[str, Any]:
    """The distance between two sets of frames in every quantity, with a yardstick.

    Args:
        ours: Generated frames.
        kitti: Labelled frames.
        splits: How many random halvings of `kitti` the yardstick averages.
        seed: Seed of the halvings.

    Returns:
        JSON-able: for each quantity its ``distance``, its ``yardstick`` (the same distance between
        two random halves of KITTI), the means of both, the ``unit`` and the ``kind`` of distance.
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
        name: {
            "kind": quantity.kind,
            "unit": quantity.unit if quantity.kind == "wasserstein" else "",
            "distance": round(quantity.distance(mine[name], real[name]), 4),
            "yardstick": round(float(np.mean(between_halves[name])), 4),
            "mean_ours": round(float(mine[name].mean()), 4),
            "mean_kitti": round(float(real[name].mean()), 4),
        }
        for name, quantity in QUANTITIES.items()
    }


def objects_per_frame(sample: Sample) -> dict[str, float]:
    """Mean number of objects of each category in a frame."""
    return {
        name: round(float(sample.of_category([name]).sum()) / sample.count, 4)
        for name in CATEGORIES
    }


def sizes_by_category(sample: Sample) -> dict[str, dict[str, list[float]]]:
    """The 10, 50 and 90 % quantiles of height, width and length in metres; known ones only."""
    sizes = {}
    for name in CATEGORIES:
        dimensions = sample.boxes.dimensions[sample.of_category([name])]
        if len(dimensions):
            quantiles = np.quantile(dimensions, [0.1, 0.5, 0.9], axis=0).round(2).T.tolist()
            sizes[name] = dict(zip(("height", "width", "length"), quantiles, strict=True))
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
) -> tuple[dict[str, Any], Sample, Sample]:
    """Everything in the figure and the table of `docs/layouts.md`.

    Args:
        kitti: Root that holds ``training/label_2``, or ``object/training/label_2``.
        scenarios: Folder of the labelled driving-safety scenarios, for the goal regions.
        count: How many layouts are generated.
        seed: Seed of their set.

    Returns:
        The JSON-able result, our sample and KITTI's.

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
        goals[road_type.value] = {
            "ours": occupied_goals(Sample.of(same)),
            "scenarios": occupied_goals(labelled[road_type]) if labelled else None,
        }
    result = {
        "layouts": {"count": count, "seed": seed},
        "kitti_frames": real.count,
        "quantities": compare(ours, real),
        "objects_per_frame": {"ours": objects_per_frame(ours), "kitti": objects_per_frame(real)},
        "sizes": {"ours": sizes_by_category(ours), "kitti": sizes_by_category(real)},
        "occupied_goals": goals,
    }
    return result, ours, real


def main(arguments: Sequence[str] | None = None) -> int:
    """Write ``layout_statistics.json`` and ``layout_statistics.png``; returns the exit code."""
    parser = argparse.ArgumentParser(description="Compare the generated layouts with KITTI.")
    parser.add_argument("--kitti", type=Path, required=True, help="root of the object benchmark")
    parser.add_argument("--scenarios", type=Path, help="labelled driving-safety scenarios")
    parser.add_argument("--out", type=Path, default=Path("docs/images"), help="for the figure")
    parser.add_argument(
        "--results", type=Path, default=Path("studies/results"), help="for the JSON file"
    )
    parser.add_argument("--count", type=int, default=7481, help="layouts to generate")
    parser.add_argument("--seed", type=int, default=0, help="of the set of layouts")
    options = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    try:
        result, ours, kitti = compare_with_kitti(
            options.kitti, options.scenarios, options.count, options.seed
        )
    except AvsecError as error:
        _LOG.error("%s", error)
        return 1
    for folder in (options.out, options.results):
        folder.mkdir(parents=True, exist_ok=True)
    target = options.results / "layout_statistics.json"
    target.write_text(json.dumps(result, indent=2) + "\n")
    from studies.world.layout_figure import draw

    figure = draw(result, ours, kitti, options.out / "layout_statistics.png")
    _LOG.info("wrote %s and %s", target, figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
