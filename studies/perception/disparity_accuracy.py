"""How exact disparities are: the small PSMNet against semi-global matching.

Run ``python -m studies.perception.disparity_accuracy --world DIR --kitti ROOT --json
FILE``: on held-out pairs of the procedural world with dense truth, and, apart from them, on the
real pairs of KITTI's stereo benchmarks at hand. Matching is done at the cameras' size, and at that
to which PSMNet reduces images, which is the fair comparison.  Semi-global matching leaves holes
where it is in doubt: all estimators are therefore compared where it finds something, too.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar, NamedTuple

import cv2
import numpy as np

from avsec_gym.console import progress
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.experiments.json_rows import FLAT, OPTIONAL
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.map_files import Disparity
from avsec_gym.kitti.stereo import KittiStereo
from avsec_gym.metrics.cluster_bootstrap import ClusterBootstrap
from avsec_gym.metrics.disparity_errors import (
    DisparityRates,
    Errors,
    PixelRates,
    disparity_errors,
    error_rates,
)
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.perception.depth.depth import DepthEstimator, DisparityMap, pair_scale
from avsec_gym.perception.depth.ground_truth import GroundTruthDepth
from avsec_gym.perception.depth.psmnet_depth import PsmNetDepth
from avsec_gym.perception.depth.sgbm import SemiGlobalMatching
from avsec_gym.perception.stereo_batch import batch_of_frames
from avsec_gym.perception.weights.given import shipped_weights
from avsec_gym.storage.regular_files import is_folder
from avsec_gym.world.export import read_manifest
from studies.answer import answer
from studies.perception.weights_facts import WeightsFacts, weights_facts

PRESETS = ("small", "medium")
"""Presets of PSMNet that are compared; both have the same weights."""
MATCHING = "sgbm"
"""Semi-global matching at the cameras' size, by name: the others are compared where it finds
something."""
_BENCHMARKS = ("stereo2012", "stereo2015")
"""The folders that they are looked for in."""


class MatchedPair(NamedTuple):
    """What is matched, and what is true."""

    frame: SensorFrame
    truth: Disparity


@dataclass(frozen=True)
class ReducedMatching:
    """Semi-global matching of pairs reduced to a network's input size."""

    name: ClassVar[str] = "sgbm_reduced"
    size: tuple[int, int]
    """Height and width, pixels."""
    disparities: int
    """Searched, of these pixels."""

    def disparity(self, frame: SensorFrame) -> DisparityMap:
        """See `DepthEstimator`; enlarged to the camera's pixels."""
        batch = batch_of_frames([frame])
        small = batch.resized(*self.size)
        pair = (
            images[0].round().clamp(0, 255).byte().permute(1, 2, 0).contiguous().numpy()
            for images in (small.left, small.right)
        )
        found = SemiGlobalMatching(disparities=self.disparities).match(*pair)
        height, width = batch.size
        smooth, nearest = (
            cv2.resize(found, (width, height), interpolation=kind)
            for kind in (cv2.INTER_LINEAR, cv2.INTER_NEAREST)
        )
        # Next to a hole nothing can be interpolated.
        values = np.where(np.isfinite(smooth), smooth, nearest) * np.float32(width / self.size[1])
        return DisparityMap(values, pair_scale(frame, 2, 3))


@dataclass(frozen=True)
class EstimatorErrors:
    """Errors of an estimator, and its time for a pair."""

    rates: DisparityRates = field(metadata=FLAT)
    seconds: float
    where_matched: PixelRates
    """Errors where semi-global matching finds something."""
    more_wrong: Estimate
    """Share of those pixels that is off by more than 3, less that of semi-global matching; its
    interval is of pairs drawn anew."""


@dataclass(frozen=True)
class MeasuredPairs:
    """Estimators on the same pairs."""

    pairs: int
    threads: int
    estimators: Mapping[str, EstimatorErrors]


@dataclass(frozen=True)
class DisparityAccuracy:
    """The result; what was not asked for is None."""

    weights: WeightsFacts | None
    input_sizes: Mapping[str, list[int]]
    """Height and width that each network reduces images to, pixels."""
    seed: int | None = field(default=None, metadata=OPTIONAL)
    """Seed of the suite that the pairs of the world are of."""
    world: MeasuredPairs | None = field(default=None, metadata=OPTIONAL)
    real: Mapping[str, MeasuredPairs] | None = field(default=None, metadata=OPTIONAL)
    """Results on real pairs, by pair."""


def run(options: argparse.Namespace) -> DisparityAccuracy:
    """Measure everything that the options name.

    Raises:
        ConfigurationError: They name nothing.
        DataError: A file is missing or broken, or there are no weights.
    """
    if options.world is None and options.kitti is None:
        raise ConfigurationError("there is nothing to judge: give --world DIR or --kitti ROOT")
    weights = options.weights or shipped_weights("psmnet_small")
    networks = {f"psmnet_{preset}": PsmNetDepth(preset, str(weights)) for preset in PRESETS}
    small = networks["psmnet_small"].configuration
    sizes = {name: each.configuration.input_size for name, each in networks.items()}
    assert small.input_size is not None, "the small network has one"
    estimators: dict[str, DepthEstimator] = {
        **networks,
        "sgbm_reduced": ReducedMatching(small.input_size, small.disparities),
        MATCHING: SemiGlobalMatching(),
    }
    result = DisparityAccuracy(
        weights_facts(weights), {name: list(size) for name, size in sizes.items() if size}
    )
    if options.world is not None:
        pairs = world_pairs(options.world, options.limit)
        world = measured(estimators, pairs, options.resamples, options.seed)
        settings = (read_manifest(options.world) or {}).get("settings") or {}
        result = replace(result, world=world, seed=settings.get("seed"))
    if options.kitti is not None:
        real = {pair.frame.id: measured(estimators, [pair]) for pair in real_pairs(options.kitti)}
        result = replace(result, real=real)
    return result


def measured(
    estimators: Mapping[str, DepthEstimator],
    pairs: Iterable[MatchedPair],
    resamples: int = 0,
    seed: int = 0,
) -> MeasuredPairs:
    """Errors of each estimator, and its time for a pair.

    Args:
        estimators: The estimators, by name; `MATCHING` is among them.
        pairs: One or more.
        resamples: Pairs are drawn anew so many times for 95 % intervals; 0: none.
        seed: The seed of these draws.
    """
    import torch

    errors: dict[str, list[Errors]] = {name: [] for name in estimators}
    where_matched: dict[str, list[Errors]] = {name: [] for name in estimators}
    seconds: dict[str, list[float]] = {name: [] for name in estimators}
    for pair in pairs:
        pair.frame.stereo()
        found = dict[str, Disparity]()
        for name, estimator in estimators.items():
            begun = time.perf_counter()
            found[name] = estimator.disparity(pair.frame).values
            seconds[name].append(time.perf_counter() - begun)
        matched = np.where(np.isfinite(found[MATCHING]), pair.truth, np.float32(np.nan))
        for name, values in found.items():
            errors[name].append(disparity_errors(values, pair.truth))
            where_matched[name].append(disparity_errors(values, matched))
    rows = {
        name: EstimatorErrors(
            error_rates(errors[name], resamples, seed),
            round(statistics.median(seconds[name]), 4),
            error_rates(where_matched[name], resamples, seed).all,
            _more_wrong(where_matched[name], where_matched[MATCHING], resamples, seed),
        )
        for name in errors
    }
    count = max(len(of_one) for of_one in errors.values())
    return MeasuredPairs(count, torch.get_num_threads(), rows)


def _more_wrong(
    errors: Sequence[Errors], others: Sequence[Errors], resamples: int, seed: int
) -> Estimate:
    """How much more of all pixels is off by 3 pixels, in one estimator than in the other."""
    pairs = ClusterBootstrap(len(errors), max(resamples, 1), seed)
    first, second = (
        pairs.ratio([each.all.off_3px for each in of], [each.all.pixels for each in of])
        for of in (errors, others)
    )
    difference = first - second
    return Estimate(round(difference.value, 5), difference.interval if resamples else None)


def world_pairs(root: Path, limit: int | None = None) -> Iterator[MatchedPair]:
    """The pairs of a procedural data set, one after another.

    Raises:
        DataError: There are none, or without true disparities.
    """
    data = KittiObject(root)
    ids = data.ids(having=("image_2", "image_3", "calib"))[:limit]
    if not ids:
        raise DataError("No frame here has a pair of images.", path=root)
    with progress("matching") as shown:
        for done, id in enumerate(ids, start=1):
            frame = data.frame(id)
            yield MatchedPair(frame, GroundTruthDepth().disparity(frame).values)
            shown(done, len(ids))


def real_pairs(kitti: Path) -> Iterator[MatchedPair]:
    """The first pairs of KITTI's stereo benchmarks, looked for in the folder and beside it.

    They come without calibration here; disparities need none, and that of a usual rig stands in.
    """
    for name in _BENCHMARKS:
        for root in (kitti / name, kitti.parent / name):
            if is_folder(root):
                data = KittiStereo(root)
                for id in data.ids(having=(data.layout.truth["occ"],)):
                    frame = replace(data.frame(id), id=f"{name} {id}")
                    yield MatchedPair(frame, data.disparity(id))


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--world", type=Path, help="frames with disparity_2, in KITTI's layout")
    parser.add_argument("--kitti", type=Path, help="root of the object benchmark; stereo2012 and"
                        " stereo2015 are looked for in it and beside it")  # fmt: skip
    parser.add_argument("--weights", type=Path, help="of the small PSMNet; default: the package's")
    parser.add_argument("--limit", type=int, help="only the first frames of the world")
    parser.add_argument("--resamples", type=int, default=1000, help="of pairs, for intervals")
    parser.add_argument("--seed", type=int, default=0, help="of these")
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
