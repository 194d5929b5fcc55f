"""How close the procedural world is to KITTI: all measurements, the page and its figures.

Run ``python -m studies.world.evidence --kitti ROOT --out studies/results``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from studies.world import checks, images, labels, occlusion, scans, stereo
from studies.world.command import command, measure_all
from studies.world.figures import draw_labels, draw_scans, draw_stereo
from studies.world.page import WorldEvidence, page


def run(options: argparse.Namespace) -> WorldEvidence:
    """Measure everything; write the page and its figures.

    The frames are rendered once for all that needs images, and once for the rest.

    Raises:
        ConfigurationError: There are no real frames to compare with.
        DataError: A real file is broken.
    """
    kitti = options.kitti
    real_labels = labels.real_sample(labels.required(kitti))
    seen = measure_all(options, stereo.measure, scans.measure, images.measure)
    known = measure_all(
        options, labels.measure, images=False, frames=max(options.frames, options.labels)
    )
    checked = measure_all(options, checks.measure, images=False, frames=options.checks)
    pairs = seen.of(stereo.measure)
    result = WorldEvidence(
        suite=options.suite,
        seed=options.seed,
        stereo=stereo.summary(pairs, stereo.real_pairs(kitti)),
        scans=scans.summary(seen.of(scans.measure), scans.real_scans(kitti)),
        images=images.summary(seen.of(images.measure), images.real_images(kitti)),
        labels=labels.summary(known.of(labels.measure), real_labels),
        occlusion=occlusion.calibrate(options, options.twins),
        checks=checks.summary(checked.of(checks.measure)),
    )
    options.images.mkdir(parents=True, exist_ok=True)
    draw_stereo(pairs, result.stereo.real, options.images / "world_stereo.png")
    draw_scans(result.scans, options.images / "world_scans.png")
    draw_labels(result.labels, options.images / "world_labels.png")
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "world.md").write_text(page(result))
    return result


def _arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--labels", type=int, default=300, help="frames whose labels are compared")
    parser.add_argument("--checks", type=int, default=50, help="frames that are checked")
    parser.add_argument("--twins", type=int, default=240, help="real frames with a twin")
    parser.add_argument("--out", type=Path, default=Path("studies/results"), help="for the page")
    parser.add_argument(
        "--images", type=Path, default=Path("studies/results/images"), help="for the figures"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write JSON, page and figures; returns the exit code."""
    return command(__doc__, arguments, run, add_arguments=_arguments)


if __name__ == "__main__":
    sys.exit(main())
