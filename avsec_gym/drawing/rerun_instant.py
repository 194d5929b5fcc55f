"""An instant of connected vehicles as a recording: all scans in one world, and what alarms."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from avsec_gym.drawing.rerun_stream import colour as rgb
from avsec_gym.drawing.rerun_stream import log_boxes, recording
from avsec_gym.geometry import Floats, rectangle_corners
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, NO_ATTACK
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

_VEHICLES = "#2E86AB", "#E08E0B", "#3C9D6E", "#8E5EA2", "#7A6A4F"
_QUIET, _ALARM = "#9AA3A8", "#D7263D"


def write_instant_recording(
    scans: Sequence[VehicleScan], path: Path, result: ConnectedResult | None = None
) -> None:
    """Write the scans of all vehicles, each in a colour of its own, in the world frame.

    Args:
        scans: The scan of each vehicle, by number.
        path: The file, ``.rrd``; one that is there is replaced.
        result: What was decided: regions that alarm are red, with kind, vehicle and probability.

    Raises:
        ConfigurationError: Rerun's SDK is not installed.
    """
    with recording(path, "connected vehicles") as stream:
        import rerun as rr

        stream.log("/", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        for number, scan in enumerate(scans):
            colours = [rgb(_VEHICLES[number % len(_VEHICLES)])]
            entity = f"vehicle_{number}"
            stream.log(f"{entity}/scan", rr.Points3D(scan.in_world(), colors=colours, radii=0.03))
            place = scan.pose[:3, 3]
            labels = [f"vehicle {number}"]
            here = rr.Points3D([place], colors=colours, radii=0.4, labels=labels)
            stream.log(f"{entity}/lidar", here)
        if result is None:
            return
        quiet = result.named == NO_ATTACK
        log_boxes(stream, "regions/quiet", region_corners(result.regions[quiet]), _QUIET)
        accused = result.accusations
        alarmed = result.regions[np.array([each.index for each in accused], np.intp)]
        words = [
            f"{each.kind}, "
            + ("cannot tell whose" if each.vehicle == CANNOT_TELL else f"vehicle {each.vehicle}")
            + f", P = {each.probability:.2f}"
            for each in accused
        ]
        log_boxes(stream, "regions/alarm", region_corners(alarmed), _ALARM, words)


def region_corners(regions: Regions) -> Floats:
    """Corners in the world: the bottom's four, then the top's, shape (N, 8, 3)."""
    poses = np.c_[regions.centre[:, :2], regions.heading]
    flat = rectangle_corners(poses, regions.size[:, 0], regions.size[:, 1])
    low = np.broadcast_to(regions.centre[:, None, 2:], (*flat.shape[:2], 1))
    high = low + regions.size[:, None, 2:]
    bottom, top = (np.concatenate([flat, height], axis=2) for height in (low, high))
    return np.concatenate([bottom, top], axis=1)
