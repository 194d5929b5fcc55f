"""LiDAR scans against rendered depth, against their label boxes, and against real scans.

Run ``python -m studies.world.scans --frames 100 --kitti ROOT``.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Points
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.sensor_files import read_points
from avsec_gym.perception.depth.lidar import visible_points
from avsec_gym.rig import SensorRig
from avsec_gym.world.capture import Capture
from avsec_gym.world.posed_scenes import PosedScene
from avsec_gym.world.site import Surface
from studies.world.command import command, measure_one
from studies.world.frames import Percentiles, quantiles
from studies.world.scan_ranges import ground_residual, range_noise

TOLERANCE = 0.05
"""Metres by which a point may lie outside its object's box."""
DEEP = 0.10
"""Metres inside a box, on all sides, where no point of anything else may lie."""
NEAR_EDGE = 5
"""Pixels from a jump in disparity within which rendered depth and scan are not compared."""
JUMP = 1.0
"""Pixels of disparity between neighbouring pixels."""

_INSIDE = 0.10

RANGES = (0.0, 3.0, 5.0, 7.5, 10.0, 15.0, 20.0, 30.0, 40.0, 60.0, 80.0, 130.0)
ELEVATIONS = (-30.0, -24.0, -20.0, -16.0, -12.0, -8.0, -4.0, -2.0, 0.0, 2.0, 4.0, 10.0)
REFLECTANCES = tuple(np.arange(11) / 10.0)


@dataclass(frozen=True)
class ScanNumbers:
    """A scan in numbers."""

    points: int
    dark: float
    """The share of points without any reflectance."""
    mean_reflectance: float
    range: list[float]
    """Shares of the points in `RANGES`."""
    elevation: list[float]
    """Shares of the points in `ELEVATIONS`."""
    reflectance: list[float]
    """Shares of the points in `REFLECTANCES`."""
    beams: list[int]
    """How many points there are in each beam, from the top."""
    noise_near: float | None
    """The noise of ranges at 4 to 12 m, metres."""
    noise_far: float | None
    """The noise of ranges at 20 to 40 m, metres."""
    residual_2m: float | None
    """Median distance of the road from planes in squares of 2 m, metres."""
    residual_5m: float | None
    """The same in squares of 5 m."""
    residual_5m_kerbs: float | None
    """Its 90th percentile."""
    off_grid: float
    """Greatest distance of a coordinate from whole millimetres, millimetres."""


@dataclass(frozen=True)
class DepthAgreement:
    """A scan beside the rendered disparity, without the points that went through panes."""

    behind_windows: int
    """Points behind the windows of vehicles: pulses pass the panes that a camera sees."""
    points: int
    """Compared points."""
    agree: float | None
    """The share of them that differs by less than a pixel of disparity."""
    median: float | None
    """Median difference, pixels."""


@dataclass(frozen=True)
class BoxAgreement:
    """A scan beside its label boxes."""

    points: int
    """Points on labelled objects."""
    inside: float | None
    """The share of them in their objects' boxes."""
    worst: float
    """This share in the worst box of ten points or more."""
    foreign: int
    """Points of other things deep in a box."""


@dataclass(frozen=True)
class RenderedScan:
    """All of it, of one frame."""

    scan: ScanNumbers
    depth: DepthAgreement
    boxes: BoxAgreement


@dataclass(frozen=True)
class DepthAgreements:
    """`DepthAgreement` of many frames."""

    points: int
    behind_windows: int
    agree: float | None
    """The share of all points that agree."""
    frames: Percentiles
    """Quantiles of each frame's share."""
    median: Percentiles


@dataclass(frozen=True)
class BoxAgreements:
    """`BoxAgreement` of many frames."""

    points: int
    inside: float | None
    """The share of all points inside."""
    worst: Percentiles
    foreign: int


@dataclass(frozen=True)
class ScanSpreads:
    """`ScanNumbers` of many scans: spreads of numbers, means of shares."""

    scans: int
    points: Percentiles
    dark: Percentiles
    mean_reflectance: Percentiles
    noise_near: Percentiles
    noise_far: Percentiles
    residual_2m: Percentiles
    residual_5m: Percentiles
    residual_5m_kerbs: Percentiles
    off_grid: Percentiles
    range: list[float]
    elevation: list[float]
    reflectance: list[float]
    beams: list[float]


@dataclass(frozen=True)
class ScanComparison:
    """Rendered scans against their own truth, and beside real ones."""

    frames: int
    depth: DepthAgreements
    boxes: BoxAgreements
    scans: ScanSpreads
    real: ScanSpreads | None


def statistics(points: Points) -> ScanNumbers:
    """A scan in numbers.

    Args:
        points: Shape (M, 4), in the order of KITTI's files.
    """
    distance = np.linalg.norm(points[:, :3], axis=1)
    elevation = np.degrees(np.arcsin(points[:, 2] / np.maximum(distance, 1e-6)))
    count, beam = max(len(points), 1), beams(points)
    thousandths = 1e3 * points[:, :3].astype(float)
    small, large = ground_residual(points, 2.0), ground_residual(points, 5.0)
    return ScanNumbers(
        points=len(points),
        dark=float((points[:, 3] == 0).mean()),
        mean_reflectance=float(points[:, 3].mean()),
        range=(np.histogram(distance, RANGES)[0] / count).tolist(),
        elevation=(np.histogram(elevation, ELEVATIONS)[0] / count).tolist(),
        reflectance=(np.histogram(points[:, 3], REFLECTANCES)[0] / count).tolist(),
        beams=np.bincount(beam).tolist(),
        noise_near=range_noise(points, beam, 4.0, 12.0),
        noise_far=range_noise(points, beam, 20.0, 40.0),
        residual_2m=small and small[0],
        residual_5m=large and large[0],
        residual_5m_kerbs=large and large[1],
        off_grid=float(np.abs(thousandths - np.round(thousandths)).max(initial=0.0)),
    )


def beams(points: Points) -> NDArray[np.int64]:
    """Which beam each point of a KITTI scan belongs to, counted from the top, shape (M,).

    A file holds beam after beam, each once round counter-clockwise from straight ahead.
    """
    turn = np.arctan2(points[:, 1], points[:, 0]) % (2 * np.pi)
    begins = np.diff(turn, prepend=turn[:1]) < -np.pi
    return np.cumsum(begins)


def against_depth(capture: Capture, rig: SensorRig) -> DepthAgreement:
    """Whether a scan agrees with the rendered disparity, which is interpolated between pixels."""
    import cv2

    assert capture.scan is not None, "this compares the scan"
    height, width = capture.disparity.shape
    uv, depth, _ = visible_points(capture.scan.points, rig.calibration, (height, width), 2)
    pixel = np.round(uv).astype(np.int64)
    baseline = rig.calibration.baseline(2, 3)
    scanned = rig.calibration.focal_length(2) * baseline / depth
    map_u, map_v = (column.astype(np.float32)[:, None] for column in uv.T)
    known = np.nan_to_num(capture.disparity)
    rendered = cv2.remap(known, map_u, map_v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    vehicle = capture.geometry.surface[pixel[:, 1], pixel[:, 0]] == Surface.VEHICLE
    deeper = depth - capture.geometry.depth[pixel[:, 1], pixel[:, 0]] > _INSIDE
    plain = ~near_edges(capture.disparity)[pixel[:, 1], pixel[:, 0]]
    passed = plain & vehicle & deeper
    difference = np.abs(scanned - rendered[:, 0])[plain & ~passed]
    return DepthAgreement(
        behind_windows=int(passed.sum()),
        points=len(difference),
        agree=float((difference < 1.0).mean()) if len(difference) else None,
        median=float(np.median(difference)) if len(difference) else None,
    )


def near_edges(disparity: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Pixels near a jump in disparity or the border of the sky, shape (H, W)."""
    import cv2

    known = np.nan_to_num(disparity)
    edge = np.zeros(known.shape, np.uint8)
    across, down = (np.abs(np.diff(known, axis=axis)) > JUMP for axis in (1, 0))
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    size = 2 * NEAR_EDGE + 1
    return np.asarray(cv2.dilate(edge, np.ones((size, size), np.uint8)) > 0)


def against_boxes(capture: Capture, rig: SensorRig) -> BoxAgreement:
    """Whether label boxes hold their objects' points, and nothing else."""
    assert capture.scan is not None, "this compares the scan"
    boxes, actor = capture.labels.boxes, capture.labels.actor
    places = transform_points(rig.calibration.velodyne_to_camera, capture.scan.points[:, :3])
    total = inside = foreign = 0
    worst = 1.0
    for index in range(len(boxes)):
        outside = distance_outside(places, boxes[index : index + 1])
        own = capture.scan.object_id == actor[index]
        held = int((outside[own] <= TOLERANCE).sum())
        count = int(own.sum())
        total, inside = total + count, inside + held
        foreign += int(((outside < -DEEP) & ~own).sum())
        if count >= 10:
            worst = min(worst, held / count)
    return BoxAgreement(total, inside / total if total else None, worst, foreign)


def distance_outside(places: Floats, box: Boxes3D) -> Floats:
    """How far points lie outside the nearest side of one box; negative inside, shape (M,)."""
    height, width, length = box.dimensions[0]
    cos, sin = np.cos(box.rotation_y[0]), np.sin(box.rotation_y[0])
    away = places - box.location[0]
    along = np.abs(cos * away[:, 0] - sin * away[:, 2]) - 0.5 * length
    across = np.abs(sin * away[:, 0] + cos * away[:, 2]) - 0.5 * width
    up = np.abs(-away[:, 1] - 0.5 * height) - 0.5 * height
    return np.asarray(np.max([along, across, up], axis=0))


def measure(posed: PosedScene, capture: Capture) -> RenderedScan:
    """All of it, of a procedural frame."""
    assert capture.scan is not None, "this measures the scan"
    return RenderedScan(
        scan=statistics(capture.scan.points),
        depth=against_depth(capture, posed.rig),
        boxes=against_boxes(capture, posed.rig),
    )


def real_scans(kitti: Path) -> dict[str, ScanNumbers]:
    """`statistics` of real scans, by frame.

    Raises:
        DataError: A file is broken.
    """
    nested = kitti / "object"
    data = KittiObject(nested if nested.is_dir() else kitti)
    ids = data.ids(having=("velodyne",))
    return {id: statistics(read_points(data.folder / "velodyne" / f"{id}.bin")) for id in ids}


def summary(rows: Sequence[RenderedScan], real: Mapping[str, ScanNumbers]) -> ScanComparison:
    """Percentiles of procedural frames beside real scans.

    Args:
        rows: The rows of `measure`.
        real: The result of `real_scans`.
    """
    depth, boxes = [row.depth for row in rows], [row.boxes for row in rows]
    return ScanComparison(
        frames=len(rows),
        depth=DepthAgreements(
            points=sum(each.points for each in depth),
            behind_windows=sum(each.behind_windows for each in depth),
            agree=_of_all_points([(each.agree, each.points) for each in depth]),
            frames=quantiles([each.agree for each in depth]),
            median=quantiles([each.median for each in depth]),
        ),
        boxes=BoxAgreements(
            points=sum(each.points for each in boxes),
            inside=_of_all_points([(each.inside, each.points) for each in boxes]),
            worst=quantiles([each.worst for each in boxes]),
            foreign=sum(each.foreign for each in boxes),
        ),
        scans=_spreads([row.scan for row in rows]),
        real=_spreads(list(real.values())) if real else None,
    )


def _of_all_points(frames: Sequence[tuple[float | None, int]]) -> float | None:
    """The mean of shares over frames, each with the weight of its points."""
    known = [(share, points) for share, points in frames if share is not None]
    total = sum(points for _, points in known)
    return sum(share * points for share, points in known) / total if total else None


def _spreads(scans: Sequence[ScanNumbers]) -> ScanSpreads:
    complete = [scan.beams for scan in scans if len(scan.beams) == 64]
    return ScanSpreads(
        scans=len(scans),
        points=quantiles([scan.points for scan in scans]),
        dark=quantiles([scan.dark for scan in scans]),
        mean_reflectance=quantiles([scan.mean_reflectance for scan in scans]),
        noise_near=quantiles([scan.noise_near for scan in scans]),
        noise_far=quantiles([scan.noise_far for scan in scans]),
        residual_2m=quantiles([scan.residual_2m for scan in scans]),
        residual_5m=quantiles([scan.residual_5m for scan in scans]),
        residual_5m_kerbs=quantiles([scan.residual_5m_kerbs for scan in scans]),
        off_grid=quantiles([scan.off_grid for scan in scans]),
        range=_mean_shares([scan.range for scan in scans]),
        elevation=_mean_shares([scan.elevation for scan in scans]),
        reflectance=_mean_shares([scan.reflectance for scan in scans]),
        beams=_mean_shares(complete),
    )


def _mean_shares(shares: Sequence[Sequence[float]]) -> list[float]:
    return np.mean(shares, axis=0).round(4).tolist()


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write JSON; returns the exit code."""
    return command(
        __doc__,
        arguments,
        lambda options: summary(
            measure_one(options, measure), real_scans(options.kitti) if options.kitti else {}
        ),
    )


if __name__ == "__main__":
    sys.exit(main())
