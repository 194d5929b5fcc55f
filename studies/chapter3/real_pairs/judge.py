"""Real pairs of images: do they alarm, and which lights are too faint to be seen in them?

Run ``python -m studies.chapter3.real_pairs.judge --kitti ROOT --json FILE``; `page` makes a page of
the result.  No threshold depends on an attack: that of brightness comes from rendered clean
frames, and is raised to what clean real pairs show, by the rule of
`avsec_gym.metrics.tolerance.tolerance_threshold`.  Nor does what a pair is judged by depend on its
own scene.  ``--fits FOLDER`` writes the raised threshold into files of thresholds.
"""

from __future__ import annotations

import argparse
import logging
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from avsec_gym.attacks.facula import Facula
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.objects.sensitivity_curves import disc_share
from avsec_gym.frame import SensorFrame
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.metrics.tolerance import ToleranceThreshold, tolerance_threshold
from avsec_gym.rig import KITTI_SIZE
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.evidence.brightness import brightness_inconsistency
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.shipped import origin_of, shipped_file
from avsec_gym.validation.thresholds import read_threshold_table
from studies.answer import answer
from studies.chapter3.real_pairs.disc_light import (
    MEAN_OF_PEAK,
    PairDifference,
    brightest_disc,
    pair_difference,
)
from studies.chapter3.real_pairs.image_pairs import LEFT, RIGHT, ImagePair, image_pairs
from studies.chapter3.real_pairs.result import (
    RULES,
    CleanPair,
    DiscFloor,
    FaintLight,
    RealPairsResult,
)

RADII = (25.0, 54.5, 77.0, 109.0, 187.0)
"""Pixels of an image 1242 wide: 2 % of its width; discs of 2, 4 and 8 % of its area; and the
thesis' smallest."""
STRENGTHS = (8.0, 16.0, 32.0, 64.0, 128.0, 255.0)
"""Grey levels at the peak; the last one is the thesis' facula as this project reads it."""
_LOG = logging.getLogger(__name__)
_ERROR_SIGMAS = 3.0


@dataclass(frozen=True, eq=False)
class SeenPair:
    """How the two images of a pair compare.

    Args:
        brightness: The value of `Brightness.patches`.
        difference: What is brighter or darker than expected.
        scale: Pixels of this image for each of one 1242 wide.
    """

    brightness: float
    difference: PairDifference
    scale: float

    def disc(self, radius: float) -> float:
        """See `brightest_disc`; the radius is in pixels of an image 1242 wide."""
        return brightest_disc(self.difference, self.scale * radius)


@dataclass(frozen=True, eq=False)
class CleanPairs:
    """All clean pairs as they are seen.

    Args:
        pairs: The pairs.
        seen: What is seen of each.
        rate: The designated false alarm rate r.
        radii: Radii of discs, pixels of an image 1242 wide.
    """

    pairs: Sequence[ImagePair]
    seen: Sequence[SeenPair]
    rate: float
    radii: Sequence[float]

    @cached_property
    def brightness(self) -> list[float]:
        """The brightness of each pair."""
        return [each.brightness for each in self.seen]

    @cached_property
    def discs(self) -> list[list[float]]:
        """The brightest disc of each pair, for each of `radii`."""
        return [[each.disc(radius) for each in self.seen] for radius in self.radii]

    def threshold(
        self, values: Sequence[float], without: str | None = None
    ) -> ToleranceThreshold | None:
        """The threshold of values of the pairs, without those of a scene; None: no pair is left."""
        kept = [number for number, pair in enumerate(self.pairs) if pair.scene != without]
        if not kept:
            return None
        scenes = [self.pairs[number].scene for number in kept]
        return tolerance_threshold([values[number] for number in kept], scenes, self.rate)


def run(options: argparse.Namespace) -> RealPairsResult:
    """Judge all pairs, clean and lit.

    Raises:
        ConfigurationError: No draws, or a rate that cannot be.
        DataError: There is no pair, or a file is broken.
    """
    if options.draws < 1:
        raise ConfigurationError(f"--draws is 1 or more, got {options.draws}")
    pairs = image_pairs(options.kitti)
    table = read_threshold_table(options.thresholds)
    depth = PairDepth.from_settings(table.on.depth)
    # Without what an earlier study raised it to: that comes from these very pairs.
    chosen = replace(table, least_brightness=0.0).thresholds(options.rate)
    rendered = min(limit.brightness for limit in chosen.values())
    frames = [pair.frame() for pair in pairs]
    clean = CleanPairs(
        pairs, [seen_pair(frame, depth) for frame in frames], options.rate, options.radii
    )
    raised = clean.threshold(clean.brightness)
    assert raised is not None, "no scene is left out"
    if options.fits is not None:
        raise_fits(options.fits, raised.value)
    rows = _clean_rows(clean, rendered)
    scenes = [pair.scene for pair in pairs]
    return RealPairsResult(
        rate=options.rate,
        draws=options.draws,
        rendered=rendered,
        origin=origin_of(table.on),
        raised=raised,
        pairs=rows,
        false_alarms={rule: share_of([row.alarms[rule] for row in rows], scenes) for rule in RULES},
        floors=[_floor(clean, place) for place in range(len(options.radii))],
        lights=_lights(clean, frames, depth, rendered, options),
    )


def seen_pair(frame: SensorFrame, depth: PairDepth) -> SeenPair:
    """How a pair's images compare.

    Args:
        frame: A frame with the images `LEFT` and `RIGHT`.
        depth: How disparities are found.
    """
    disparity = depth.estimator(frame.calibration, LEFT, RIGHT).disparity(frame).values
    left, right = frame.image(LEFT), frame.image(RIGHT)
    patches = brightness_inconsistency(left, right, disparity).patches
    scale = left.shape[1] / KITTI_SIZE[0]
    return SeenPair(patches, pair_difference(frame, disparity), scale)


def raise_fits(folder: Path, least: float) -> None:
    """Write the least threshold of brightness into all files of thresholds of a folder.

    Args:
        folder: The folder.
        least: The threshold.

    Raises:
        DataError: A file is broken, or cannot be written.
    """
    for path in sorted(folder.glob("*.thresholds.json")):
        table = replace(read_threshold_table(path), least_brightness=least)
        table.write(path, overwrite=True)


@dataclass(frozen=True)
class PairLimits:
    """What a pair is judged by; what comes from real pairs is from other scenes.

    Args:
        rendered: Threshold of brightness from rendered frames.
        raised: The same threshold, raised by other scenes.
        discs: The brightest clean disc of each size in other scenes; None: there is no other.
    """

    rendered: float
    raised: float
    discs: Sequence[float] | None

    def alarms(self, seen: SeenPair, radii: Sequence[float]) -> dict[str, bool]:
        """Whether each of `RULES` alarms.

        Args:
            seen: What is seen of the pair.
            radii: Radii of the discs.
        """
        shines = self.discs is not None and any(
            seen.disc(radius) > limit for radius, limit in zip(radii, self.discs, strict=True)
        )
        found = (seen.brightness > self.rendered, seen.brightness > self.raised, shines)
        return dict(zip(RULES, found, strict=True))


def pair_limits(clean: CleanPairs, scene: str, rendered: float) -> PairLimits:
    """What the pairs of a scene are judged by."""
    others = clean.threshold(clean.brightness, without=scene)
    if others is None:
        return PairLimits(rendered, rendered, None)
    discs = [clean.threshold(values, without=scene) for values in clean.discs]
    return PairLimits(
        rendered, max(rendered, others.value), [disc.value for disc in discs if disc is not None]
    )


def _clean_rows(clean: CleanPairs, rendered: float) -> list[CleanPair]:
    return [
        CleanPair(
            pair.id,
            pair.scene,
            seen.brightness,
            seen.difference.pixel_noise,
            pair_limits(clean, pair.scene, rendered).alarms(seen, clean.radii),
        )
        for pair, seen in zip(clean.pairs, clean.seen, strict=True)
    ]


def _floor(clean: CleanPairs, place: int) -> DiscFloor:
    radius, floor = clean.radii[place], clean.threshold(clean.discs[place])
    assert floor is not None, "no scene is left out"
    noise = float(np.median([each.difference.pixel_noise for each in clean.seen]))
    return DiscFloor(
        radius,
        disc_share(radius),
        floor,
        floor.value / MEAN_OF_PEAK,
        _ERROR_SIGMAS * noise / float(np.sqrt(np.pi) * radius),
    )


def _lights(
    clean: CleanPairs,
    frames: Sequence[SensorFrame],
    depth: PairDepth,
    rendered: float,
    options: argparse.Namespace,
) -> list[FaintLight]:
    rows, cases = [], [(r, s) for r in options.radii for s in options.strengths]
    start = time.perf_counter()
    scenes = [pair.scene for pair in clean.pairs]
    limits = [pair_limits(clean, scene, rendered) for scene in scenes]
    for done, (radius, strength) in enumerate(cases, start=1):
        hits = np.zeros((len(frames), options.draws, len(RULES)), bool)
        for number, frame in enumerate(frames):
            for draw in range(options.draws):
                # Either camera in turn; of one draw all lights stand at one place.
                camera = (LEFT, RIGHT)[draw % 2]
                light = Facula(camera, radius, strength=strength)
                lit = light.attack(frame, (options.seed, number, draw)).frame
                alarms = limits[number].alarms(seen_pair(lit, depth), clean.radii)
                hits[number, draw] = [alarms[rule] for rule in RULES]
        rows.append(
            FaintLight(
                radius,
                strength,
                {rule: share_of(hits[:, :, place], scenes) for place, rule in enumerate(RULES)},
            )
        )
        left = (time.perf_counter() - start) * (len(cases) / done - 1)
        _LOG.info("%d of %d lights, about %.0f s left", done, len(cases), left)
    return rows


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kitti", type=Path, required=True, help="folder of KITTI's data sets")
    parser.add_argument("--draws", type=int, default=8, help="of each light's place in a pair")
    parser.add_argument("--rate", type=float, default=0.01, help="r")
    parser.add_argument("--seed", type=int, default=0, help="of the draws")
    parser.add_argument("--radii", type=float, nargs="+", default=RADII, help="pixels of 1242")
    parser.add_argument("--strengths", type=float, nargs="+", default=STRENGTHS, help="grey levels")
    parser.add_argument(
        "--thresholds",
        type=Path,
        default=shipped_file("thresholds", LIDAR_AND_TWO_CAMERAS),
        help="of rendered frames; default: the package's",
    )
    parser.add_argument("--fits", type=Path, help="folder of thresholds that are raised")
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
