"""How hard a pair of images is for a plain stereo matcher, against LiDAR or dense truth.

Run ``python -m studies.world.stereo --frames 100 --kitti ROOT``.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.map_files import Disparity, read_disparity
from avsec_gym.kitti.sensor_files import read_image
from avsec_gym.perception.depth.lidar import scan_disparity
from avsec_gym.perception.depth.sgbm import SemiGlobalMatching
from avsec_gym.world.capture import Capture
from avsec_gym.world.posed_scenes import PosedScene
from studies.world.command import command, measure_one
from studies.world.frames import Percentiles, quantiles

FIRST_COLUMN = 130
"""The matcher's search leaves out what lies further left."""
MIN_ERROR, MIN_RELATIVE_ERROR = 3.0, 0.05
"""A disparity is wrong if it is off by more than both: pixels, share of the true one."""

match = SemiGlobalMatching().match
"""The matcher, with usual settings for KITTI."""


@dataclass(frozen=True)
class MatcherErrors:
    """Where the matcher found a disparity, and how often that is wrong; None without truth."""

    wrong: float | None
    """The share of the true pixels with a disparity."""
    density: float | None
    """The share of the true pixels that have one."""
    filled: float
    """The share of all pixels that have one."""
    mean_error: float | None
    """The mean error, pixels."""
    median_error: float | None
    """The median error, pixels."""
    pixels: int
    """How many true ones there are."""


@dataclass(frozen=True)
class RenderedPair:
    """A rendered pair against its scan, and against dense truth."""

    lidar: MatcherErrors
    dense: MatcherErrors


@dataclass(frozen=True)
class MatcherErrorSpreads:
    """The spread of each number of `MatcherErrors` over pairs."""

    wrong: Percentiles
    density: Percentiles
    filled: Percentiles
    mean_error: Percentiles
    median_error: Percentiles


@dataclass(frozen=True)
class StereoDifficulty:
    """How hard rendered pairs are, beside real ones."""

    frames: int
    lidar: MatcherErrorSpreads
    dense: MatcherErrorSpreads
    real: Mapping[str, MatcherErrors]
    """Real pairs by name."""


def compare(found: Disparity, truth: Disparity) -> MatcherErrors:
    """Where the matcher found a disparity, and how often that is wrong.

    Args:
        found: Shape (H, W), pixels, NaN where unknown.
        truth: The true disparity, pixels.
    """
    known = np.isfinite(truth)
    known[:, :FIRST_COLUMN] = False
    valid = known & np.isfinite(found)
    error = np.abs(found[valid] - truth[valid])
    wrong = (error > MIN_ERROR) & (error > MIN_RELATIVE_ERROR * truth[valid])
    some = len(error) > 0
    return MatcherErrors(
        wrong=float(wrong.mean()) if some else None,
        density=float(valid.sum() / known.sum()) if known.any() else None,
        filled=float(np.isfinite(found[:, FIRST_COLUMN:]).mean()),
        mean_error=float(error.mean()) if some else None,
        median_error=float(np.median(error)) if some else None,
        pixels=int(known.sum()),
    )


def measure(posed: PosedScene, capture: Capture) -> RenderedPair:
    """A procedural pair of cameras 2 and 3: against its scan, and against dense truth."""
    found = match(capture.images[2], capture.images[3])
    assert capture.scan is not None, "the scan is one of the truths"
    shape = found.shape[0], found.shape[1]
    sparse = scan_disparity(capture.scan.points, posed.rig.calibration, shape, (2, 3))
    return RenderedPair(lidar=compare(found, sparse), dense=compare(found, capture.disparity))


def real_pairs(kitti: Path) -> dict[str, MatcherErrors]:
    """The same of real pairs, by name.

    Args:
        kitti: Folder of the object benchmark; ``stereo2012`` and ``stereo2015`` are looked for
            beside it, or in it.

    Raises:
        DataError: A file is broken.
    """
    nested = kitti / "object"
    data = KittiObject(nested if nested.is_dir() else kitti)
    results: dict[str, MatcherErrors] = {}
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


def summary(rows: Sequence[RenderedPair], real: Mapping[str, MatcherErrors]) -> StereoDifficulty:
    """Percentiles over procedural pairs beside the real ones.

    Args:
        rows: The rows of `measure`.
        real: The result of `real_pairs`.
    """
    lidar, dense = [row.lidar for row in rows], [row.dense for row in rows]
    return StereoDifficulty(len(rows), _spreads(lidar), _spreads(dense), real)


def _spreads(pairs: Sequence[MatcherErrors]) -> MatcherErrorSpreads:
    return MatcherErrorSpreads(
        wrong=quantiles([pair.wrong for pair in pairs]),
        density=quantiles([pair.density for pair in pairs]),
        filled=quantiles([pair.filled for pair in pairs]),
        mean_error=quantiles([pair.mean_error for pair in pairs]),
        median_error=quantiles([pair.median_error for pair in pairs]),
    )


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
