"""The drift of estimated ego motion, and how many windows of KITTI tracking can be driven in.

Run ``python -m studies.driving_safety.ego_motion --tracking DIR --json FILE``.  The drift is
measured on procedural drives that are written as tracking labels with errors, whose motion is
known; windows are counted in KITTI's own sequences.  Nothing is rendered.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from avsec_gym import console
from avsec_gym.closed_loop.recorded.recorded_motion import from_first
from avsec_gym.closed_loop.recorded.recorded_scenes import recorded_windows
from avsec_gym.closed_loop.recorded.sources import KITTI_TRACKING
from avsec_gym.closed_loop.recorded.tracking_traffic import traffic_of_frames
from avsec_gym.closed_loop.recorded.windows import LENGTH, known_motion
from avsec_gym.report.markdown_table import number
from avsec_gym.world.drives import drive_scenes
from studies.answer import answer
from studies.driving_safety.procedural_labels import drive_labels
from studies.result_fields import field, is_made, number_at

DRIVES, SEED = 40, 7
"""Procedural drives of 10 s."""
_FRAMES, _EVERY = 101, 1.0
_RESULT = "ego_motion"


def window_drifts(number: int) -> list[tuple[float, float]]:
    """How far off the estimate is at the end of each window of a procedural drive, m and degrees.

    Args:
        number: Number of the drive.
    """
    frames, truth = drive_labels(drive_scenes(SEED, number, _FRAMES), number)
    known = known_motion(traffic_of_frames("drive", len(frames), frames, None))
    drifts = []
    for first in known.starts(_EVERY)[0]:
        ends = [from_first(poses, first)[first + LENGTH] for poses in (known.poses, truth)]
        off = ends[0] - ends[1]
        drifts.append((float(np.hypot(*off[:2])), float(np.degrees(abs(off[2])))))
    return drifts


def measured(tracking: Path) -> dict[str, object]:
    """The result.

    Args:
        tracking: Root of the KITTI tracking data.

    Raises:
        DataError: There is no sequence, or a file is broken.
    """
    drifts: list[tuple[float, float]] = []
    with console.progress("procedural drives") as shown:
        for number in range(DRIVES):
            drifts += window_drifts(number)
            shown(number + 1, DRIVES)
    windows = recorded_windows(KITTI_TRACKING, tracking)
    refused = sum((each.refused for each in windows), Counter[str]())
    off, turned = np.array(drifts).T
    return {
        "drift": {
            "drives": DRIVES,
            "windows": len(drifts),
            "seconds": LENGTH / 10,
            "worst_metres": float(off.max()),
            "median_metres": float(np.median(off)),
            "worst_degrees": float(turned.max()),
        },
        "tracking": {
            "sequences": len(windows),
            "sequences_driven_in": sum(bool(each.starts) for each in windows),
            "windows": sum(len(each.starts) for each in windows),
            "refused": {str(reason): count for reason, count in refused.most_common()},
        },
    }


def ego_motion_lines() -> list[str]:
    """The paragraph of docs/closed_loop.md."""
    if not is_made(_RESULT):
        return [
            "How far the estimate drifts, and how many windows and sequences there are, has not"
            " been measured yet: `python -m studies.ego_motion --tracking DIR`."
        ]
    return [
        f"Of {_of('drift', 'drives')} such procedural drives, {_of('drift', 'windows')} windows"
        f" count; after {_of('drift', 'seconds')} s the estimate is off by"
        f" {_of('drift', 'median_metres', 2)} m in the median, and at worst by"
        f" {_of('drift', 'worst_metres', 2)} m and {_of('drift', 'worst_degrees', 2)} degrees."
        f" KITTI's {_of('tracking', 'sequences')} labelled sequences give"
        f" {_of('tracking', 'windows')} windows, all from"
        f" {_of('tracking', 'sequences_driven_in')} sequences, which are the clusters of intervals."
    ]


def _of(part: str, name: str, digits: int = 0) -> str:
    return number(number_at(field(_RESULT, part, name)), digits)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--tracking", type=Path, required=True, help="KITTI tracking data")
    parser.add_argument("--json", type=Path, help="the result; default: standard output")
    options = parser.parse_args(arguments)
    return answer(options, lambda asked: measured(asked.tracking))


if __name__ == "__main__":
    sys.exit(main())
