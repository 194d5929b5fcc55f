"""Depth of a solved box from the pixels themselves (Li et al. 2019, section 5).

The lower half of a car's image, between its borders, is taken to lie on those faces of the box
that look at the camera.  For every depth of the box's centre, this gives where each left pixel is
in the right image; the depth whose colours differ least is the box's.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats, Integers
from avsec_gym.kernels import kernel
from avsec_gym.perception.detectors.stereo_rcnn.alignment import Alignment
from avsec_gym.perception.detectors.stereo_rcnn.box_solver import ObservedBoxes, SolvedBoxes
from avsec_gym.perception.detectors.stereo_rcnn.stereo_camera import StereoCamera

NetworkPixels = NDArray[np.float32]
"""Shape (H, W, 3), grey levels."""

_UPPER_END, _LOWER_END = 0.5, 0.9
_NEAR = 0.1
_ELSEWHERE = 0.12
"""Share of its depth by which another depth differs at least."""


class AlignedDepths(NamedTuple):
    """The depths of N boxes."""

    depth: Floats
    """z in the left camera's frame, shape (N,), metres; the solver's where nothing was found."""
    found: NDArray[np.bool_]
    """Whether there were pixels to find it by, shape (N,)."""
    contrast: Floats
    """How much better colours agree there than at any other depth, shape (N,): the logarithm of the
    ratio of mean differences, each with one grey level more; 0 where nothing was found."""


def align_depths(
    left: NetworkPixels,
    right: NetworkPixels,
    observed: ObservedBoxes,
    solved: SolvedBoxes,
    camera: StereoCamera,
    how: Alignment = Alignment(),
) -> AlignedDepths:
    """Depths of the centres of N boxes.

    Args:
        left: The left image.
        right: The right image.
        observed: What the network found, for the windows: left boxes and borders.
        solved: The boxes.
        camera: The camera of images of this very size.
        how: The search.
    """
    before = solved.location[:, 2]
    u, v, behind, start = _surface(observed, solved, camera, how)
    left, right = np.ascontiguousarray(left, np.float32), np.ascontiguousarray(right, np.float32)
    product = camera.focal_times_baseline
    most = np.inf if how.most_difference is None else how.most_difference

    def differences(depths: Floats) -> Floats:
        return _differences(left, right, u, v, behind, start, depths, product, most)

    # Coarse search about the depth that the solver found, no nearer than what is plausible.
    steps = np.arange(how.coarse_steps) - how.coarse_steps // 2
    coarse = np.maximum(before[:, None] + how.coarse_interval * steps, how.nearest)
    coarse_costs = differences(coarse)
    best = _picked(coarse, coarse_costs.argmin(axis=1))
    # The best of the depths that are clearly others: what the contrast is measured against.
    elsewhere = np.abs(coarse - best[:, None]) > _ELSEWHERE * best[:, None]
    other = np.where(elsewhere, coarse_costs, np.inf).min(axis=1, initial=np.inf)
    # Fine search about the coarse one's best, between whose steps a parabola may interpolate.
    steps = np.arange(how.fine_steps) - how.fine_steps // 2
    fine = best[:, None] + how.fine_interval * steps
    costs = differences(fine)
    best = _picked(fine, costs.argmin(axis=1))
    if how.parabola:
        best = best + how.fine_interval * _vertex(costs)
    # Boxes without a pixel keep the depth that they had.
    found = (np.diff(start) > 0) & (best > 0)
    with np.errstate(divide="ignore"):
        aligned = product / (product / best + how.disparity_offset)
    colours = np.maximum(3 * np.diff(start), 1)
    levels = (other / colours + 1.0) / (costs.min(axis=1, initial=np.inf) / colours + 1.0)
    contrast = np.where(found & np.isfinite(levels), np.log(np.maximum(levels, 1e-3)), 0.0)
    return AlignedDepths(np.where(found, aligned, before), found, contrast)


def _picked(rows: Floats, index: NDArray[np.intp]) -> Floats:
    return np.asarray(np.take_along_axis(rows, index[:, None], axis=1)[:, 0])


def _vertex(costs: Floats) -> Floats:
    """Where a parabola through the least cost and its neighbours ends, in steps from the least."""
    middle = costs.argmin(axis=1)
    inner = np.clip(middle, 1, costs.shape[1] - 2)
    before, least, after = (_picked(costs, inner + step) for step in (-1, 0, 1))
    bend = before + after - 2 * least
    with np.errstate(divide="ignore", invalid="ignore"):
        vertex = 0.5 * (before - after) / bend
    return np.where((bend > 0) & (middle == inner), vertex, 0.0)


def _surface(
    observed: ObservedBoxes, solved: SolvedBoxes, camera: StereoCamera, how: Alignment
) -> tuple[Integers, Integers, Floats, Integers]:
    """Pixels u, v, how far their surface is behind the centre (metres), and where boxes start."""
    box, borders = observed.left, observed.borders
    height = box[:, 3] - box[:, 1]
    rows = box[:, 1, None] + height[:, None] * [_UPPER_END, _LOWER_END]
    ends = np.hstack([rows, borders])
    limits = [camera.size[0], camera.size[0], camera.size[1], camera.size[1]]
    windows = np.clip((ends + 0.5).astype(np.int64), 0, limits)
    strides = np.maximum(
        (np.column_stack([height, borders[:, 1] - borders[:, 0]]) / how.most_pixels).astype(int), 1
    )
    box_height, width, length = observed.dimensions.T
    side, front, rear = how.side_inset, how.front_inset, how.rear_inset
    lower = np.column_stack([-width / 2 + side, -box_height, -length / 2 + rear])
    upper = np.column_stack([width / 2 - side, np.zeros(len(width)), length / 2 - front])
    lens = np.array([*camera.focal_length, *camera.centre])
    return _surface_pixels(windows, strides, solved.location, solved.rotation_y, lower, upper, lens)


@kernel(nogil=True)
def _surface_pixels(
    windows: Integers,
    strides: Integers,
    location: Floats,
    rotation_y: Floats,
    lower: Floats,
    upper: Floats,
    lens: Floats,
) -> tuple[Integers, Integers, Floats, Integers]:
    """The pixels of the windows whose rays enter the box.

    It is between `lower` and `upper` in its own axes: across, down, along.
    """
    # Room for all pixels of all windows, as if every ray entered its box.
    count = len(windows)
    room = 0
    for i in range(count):
        top, bottom, first, last = windows[i]
        room += max(0, bottom - top) * max(0, last - first)
    us, vs = np.empty(room, np.int64), np.empty(room, np.int64)
    behind, start = np.empty(room), np.zeros(count + 1, np.int64)
    # Invariant: the first `used` places are filled, box by box; box i begins at start[i].
    used = 0
    for i in range(count):
        # The camera's centre in the axes of the box.
        theta = rotation_y[i] + np.pi / 2
        cos, sin = np.cos(theta), np.sin(theta)
        x, y, z = location[i]
        origin = (-(cos * x - sin * z), -y, -(sin * x + cos * z))
        top, bottom, first, last = windows[i]
        for v in range(top, bottom, strides[i, 0]):
            down = (v - lens[3]) / lens[1]
            for u in range(first, last, strides[i, 1]):
                aside = (u - lens[2]) / lens[0]
                # Slabs: the ray is in the box where it is between all three pairs of faces.
                ray = (cos * aside - sin, down, sin * aside + cos)
                enter, leave = 0.0, np.inf
                for axis in range(3):
                    # Nearly parallel to a face: far beyond any box instead of divided by zero.
                    slope = ray[axis] if abs(ray[axis]) > 1e-12 else 1e-12
                    one = (lower[i, axis] - origin[axis]) / slope
                    two = (upper[i, axis] - origin[axis]) / slope
                    enter, leave = max(enter, min(one, two)), min(leave, max(one, two))
                # In the camera frame a ray's z is 1, so that its parameter is a depth.
                if 0 < enter < leave:
                    us[used], vs[used], behind[used] = u, v, enter - z
                    used += 1
        start[i + 1] = used
    return us[:used], vs[:used], behind[:used], start


@kernel(nogil=True)
def _differences(
    left: NetworkPixels,
    right: NetworkPixels,
    us: Integers,
    vs: Integers,
    behind: Floats,
    start: Integers,
    depths: Floats,
    product: float,
    most: float,
) -> Floats:
    """Sum over pixels and colours of |left - right|, at most `most`, for depths (N, S), (N, S)."""
    count, steps = depths.shape
    result = np.zeros((count, steps))
    last = right.shape[1] - 1
    for i in range(count):
        for j in range(start[i], start[i + 1]):
            u, v = us[j], vs[j]
            red, green, blue = left[v, u]
            for s in range(steps):
                # The pixel's column in the right image, clamped: the image's edge goes on.
                place = u - product / max(depths[i, s] + behind[j], _NEAR)
                place = min(max(place, 0.0), last - 1e-6)
                k = int(place)
                share = place - k
                one, two = right[v, k], right[v, k + 1]
                result[i, s] += (
                    min(abs(red - one[0] - share * (two[0] - one[0])), most)
                    + min(abs(green - one[1] - share * (two[1] - one[1])), most)
                    + min(abs(blue - one[2] - share * (two[2] - one[2])), most)
                )
    return result
