"""How hard a pair of images is for a plain stereo matcher, against LiDAR or dense truth.

Run ``python -m studies.world.stereo --frames 100 --kitti ROOT``.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.map_files import Disparity, read_disparity
from avsec_gym.kitti.sensor_files import read_image
from avsec_gym.perception.depth.lidar import scan_disparity
from avsec_gym.perception.depth.sgbm import SemiGlobalMatching
from avsec_gym.world.capture import Capture
from avsec_gym.world.posed_scenes import PosedScene
from studies.world.command import command, measure_one
from studies.world.frames import quantiles

FIRST_COLUMN = 130
"""The matcher's search leaves out what lies further left."""
MIN_ERROR, MIN_RELATIVE_ERROR = 3.0, 0.05
"""A disparity is wrong if it is off by more than both: pixels, share of the true one."""

match = SemiGlobalMatching().match
"""The matcher, with usual settings for KITTI."""


def compare(found: Disparity, truth: Disparity) -> dict[str, float | int | None]:
    """Where the matcher found a disparity, and how often that is wrong.

    Args:
        found: Shape (H, W), pixels, NaN where unknown.
        truth: The same.

    Returns:
        JSON-able: the share of true pixels with a disparity (``density``), of these the share
        that are ``wrong``, the mean and the median ``error`` in pixels, and how many there are;
        without truth only the share of all pixels.
    """
    known = np.isfinite(truth)
    known[:, :FIRST_COLUMN] = False
    valid = known & np.isfinite(found)
    error = np.abs(found[valid] - truth[valid])
    wrong = (error > MIN_ERROR) & (error > MIN_RELATIVE_ERROR * truth[valid])
    some = len(error) > 0
    return {
        "wrong": float(wrong.mean()) if some else None,
        "density": float(valid.sum() / known.sum()) if known.any() else None,
        "filled": float(np.isfinite(found[:, FIRST_COLUMN:]).mean()),
        "mean_error": float(error.mean()) if some else None,
        "median_error": float(np.median(error)) if some else None,
        "pixels": int(known.sum()),
    }


def measure(posed: PosedScene, capture: Capture) -> dict[str, Any]:
    """A procedural pair of cameras 2 and 3: against its scan, and against dense truth."""
    found = match(capture.images[2], capture.images[3])
    assert capture.scan is not None, "the scan is one of the truths"
    shape = found.shape[0], found.shape[1]
    sparse = scan_disparity(capture.scan.points, posed.rig.calibration, shape, (2, 3))
    return {"lidar": compare(found, sparse), "dense": compare(found, capture.disparity)}


def real_pairs(kitti: Path) -> dict[str, dict[str, Any]]:
    """The same of real pairs, by name.

    Args:
        kitti: Folder of the object benchmark; ``stereo2012`` and ``stereo2015`` are looked for
            beside it, or in it.

    Raises:
        DataError: A file is broken.
    """
    nested = kitti / "object"
    data = KittiObject(nested if nested.is_dir() else kitti)
    results: dict[str, dict[str, Any]] = {}
    for id in data.ids(having=("image_2", "image_3", "calib")):
        frame = data.frame(id)
        found = match(frame.image(2), frame.image(3))
        shape = found.shape[0], found.shape[1]
        truth = np.full(shape, np.nan, np.float32)
        if frame.has_points:
            truth = scan_disparity(frame.points, frame.calibration, shape, (2, 3))
        results[f"object {id}"] = compare(found, truth)
    for name, (left, right, truth_name) in _STEREO.items():
        for base in (kitti, kitti.parent):
            folder = base / name / "training"
            for path in sorted((folder / truth_name).glob("*_10.png")):
                pair = (read_image(folder / side / path.name) for side in (left, right))
                results[f"{name} {path.stem}"] = compare(match(*pair), read_disparity(path))
    return results


_STEREO = {
    "stereo2012": ("colored_0", "colored_1", "disp_occ"),
    "stereo2015": ("image_2", "image_3", "disp_occ_0"),
}
"""Left and right images and truth."""


def summary(rows: Sequence[dict[str, Any]], real: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """Percentiles over procedural pairs beside the real ones.

    Args:
        rows: The rows of `measure`.
        real: The result of `real_pairs`.
    """
    return {
        "frames": len(rows),
        **{
            truth: {
                name: quantiles([row[truth][name] for row in rows])
                for name in ("wrong", "density", "filled", "mean_error", "median_error")
            }
            for truth in ("lidar", "dense")
        },
        "real": real,
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write JSON; returns the exit code."""
    return command(
        __doc__,
        arguments,
        lambda options: summary(
            measure_one(options, measure), real_pairs(options.kitti) if options.kitti else {}
        ),
    )


if __name__ == "__main__":
    sys.exit(main())
