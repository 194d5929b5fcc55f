"""Seconds to score 3,769 frames, three classes, every metric; prints JSON.

    python benchmarks/average_precision.py [--kitti ROOT --split val --detections DIR]

Without arguments it writes random labels and detections, about as many as KITTI's, to a temporary
folder.  `command` is `avsec ap --json`, process start and reading of the text files included, once
the kernels are compiled (`first` compiles them where they are not); `in_memory` is the function.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.kitti import DetectionFolder, KittiObject, write_detections, write_labels
from avsec_gym.metrics.average_precision import average_precision

FRAMES, RUNS, RESAMPLES = 3769, 5, 1000
CLASSES = ["Car", "Car", "Car", "Car", "Van", "Pedestrian", "Cyclist"]


def main() -> None:
    """Measure, print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kitti", type=Path)
    parser.add_argument("--split", default="val")
    parser.add_argument("--detections", type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        kitti, detections = arguments.kitti, arguments.detections
        if kitti is None or detections is None:
            kitti, detections = Path(folder) / "kitti", Path(folder) / "detections"
            write_random_frames(kitti, detections)
        print(json.dumps(measured(kitti, arguments.split, detections), indent=1))


def measured(kitti: Path, split: str, detections: Path) -> dict[str, float]:
    command = [
        sys.executable, "-m", "avsec_gym", "ap", "--kitti", str(kitti), "--split", split,
        "--detections", str(detections), "--json",
    ]  # fmt: skip
    first = seconds(lambda: subprocess.run(command, check=False, capture_output=True), 1)
    again = seconds(lambda: subprocess.run(command, check=False, capture_output=True), RUNS)
    data = KittiObject(kitti)
    found = DetectionFolder(detections).read(data.ids(split))[0]
    truth = [data.labels(id, keep_dont_care=True) for id in found]
    boxes = list(found.values())
    average_precision(truth[:9], boxes[:9], resamples=2)
    return {
        "frames": len(truth),
        "labels": sum(map(len, truth)),
        "detections": sum(map(len, boxes)),
        "first_seconds": first,
        "command_seconds": again,
        "in_memory_seconds": seconds(lambda: average_precision(truth, boxes), RUNS),
        f"in_memory_{RESAMPLES}_resamples_seconds": seconds(
            lambda: average_precision(truth, boxes, resamples=RESAMPLES), RUNS
        ),
        "runs": RUNS,
    }


def seconds(call: Callable[[], object], runs: int) -> float:
    """Median wall time."""
    taken = []
    for _ in range(runs):
        begun = time.perf_counter()
        call()
        taken.append(time.perf_counter() - begun)
    return round(statistics.median(taken), 3)


def write_random_frames(kitti: Path, detections: Path) -> None:
    random = np.random.default_rng(0)
    ids = [f"{number:06d}" for number in range(FRAMES)]
    for id in ids:
        labels = random_boxes(random, int(random.integers(0, 12)))
        found = Boxes3D.concatenate([labels, random_boxes(random, int(random.integers(0, 8)))])
        found = replace(
            found,
            location=found.location + random.normal(0, 0.1, found.location.shape),
            score=random.random(len(found)),
        )
        write_labels(kitti / "training" / "label_2" / f"{id}.txt", labels)
        write_detections(detections / f"{id}.txt", found)
    split = kitti / "ImageSets" / "val.txt"
    split.parent.mkdir()
    split.write_text("\n".join(ids))


def random_boxes(random: np.random.Generator, count: int) -> Boxes3D:
    corner = random.uniform([0, 100], [1100, 200], (count, 2))
    size = random.uniform([20, 20], [200, 120], (count, 2))
    return Boxes3D(
        location=random.uniform([-20, 1.4, 5], [20, 2, 60], (count, 3)),
        dimensions=random.uniform([1.3, 1.4, 3.2], [1.9, 1.9, 4.6], (count, 3)),
        rotation_y=random.uniform(-3, 3, count),
        score=np.ones(count),
        category=random.choice(CLASSES, count),
        box2d=np.hstack([corner, corner + size]),
        truncation=np.zeros(count),
        occlusion=random.integers(0, 4, count),
        alpha=random.uniform(-3, 3, count),
    )


if __name__ == "__main__":
    main()
