"""Voxels in which rays end, by looking at every ray."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.box_voxels import (
    VOXEL,
    _cells_of_box,
    fill_places,
    voxels_in_boxes,
)
from avsec_gym.validation.connected.rays.range_image import RangeImage, cells_between
from avsec_gym.validation.connected.sweep import TIP
from tests.validation.connected.rays.rays_by_hand import (
    Motion,
    after,
    faced,
    image_of,
    tilted_pose,
)


class _Boxes(NamedTuple):
    velocity: Floats
    centre: Floats
    ahead: Floats
    half: Floats
    shape: NDArray[np.int64]


def _boxes(
    velocity: Floats, centre: Floats, heading: Floats, half: Floats, fewer: int = 0
) -> _Boxes:
    """Upright boxes; with `fewer` voxels than fit, what lies beyond counts for the last."""
    ahead = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    shape = np.ceil(2 * half / VOXEL - 1e-9).astype(np.int64) - fewer
    return _Boxes(velocity, centre, ahead, half, shape)


def _seen_of(
    rng: np.random.Generator, boxes: _Boxes, pose: Floats, motion: Motion, age: float, count: int
) -> tuple[Floats, Floats]:
    """Directions and distances of rays that end at the corners of boxes, and around."""
    directions, distance = [], []
    to_sensor = np.linalg.inv(pose)
    for b in range(len(boxes.centre)):
        cos, sin = boxes.ahead[b]
        # Most of them a little inside or outside of an edge of the box.
        edge = 1.0 + rng.choice([-1.0, 1.0], (count, 3)) * rng.uniform(0.003, 0.05, (count, 3))
        edge *= rng.choice([-1.0, 1.0], (count, 3))
        along, across, up = np.where(rng.random((count, 3)) < 0.6, edge, edge * rng.random()).T
        along, across, up = along * boxes.half[b, 0], across * boxes.half[b, 1], up + 1.0
        place = np.stack(
            [cos * along - sin * across, sin * along + cos * across, up * boxes.half[b, 2]], 1
        )
        place += boxes.centre[b]
        # What moves is where it is when the head faces it.
        time = np.zeros(count)
        for _ in range(30):
            moved = place.copy()
            moved[:, :2] += (age + time)[:, None] * boxes.velocity[b]
            x, y, z = (moved @ to_sensor[:3, :3].T + to_sensor[:3, 3]).T
            vehicle, heading = after(time, motion)
            seen = (x + 1j * y - vehicle) / heading
            time = np.angle(seen) * motion[2] / (2 * np.pi)
        directions.append(np.stack([np.angle(seen), np.arctan2(z - TIP, np.abs(seen))], axis=1))
        distance.append(np.hypot(np.abs(seen), z - TIP))
    return np.concatenate(directions), np.concatenate(distance)


def _judged(
    image: RangeImage, pose: Floats, motion: Motion, age: float, boxes: _Boxes, floor: float
) -> list[tuple[int, int]]:
    """Box and voxel of every ray that ends in a box."""
    found = []
    ends = image.end.astype(float) @ pose[:3, :3].T + pose[:3, 3]
    later = age + image.azimuth.astype(float) * motion[2] / (2 * np.pi)
    for b, (velocity, centre, (cos, sin), half, shape) in enumerate(zip(*boxes, strict=True)):
        off = ends - centre
        off[:, :2] -= later[:, None] * velocity
        local = off @ np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
        # From the corner of the box.
        local += [half[0], half[1], 0.0]
        inside = ((local > [0, 0, floor]) & (local < 2 * half)).all(axis=1)
        index = np.minimum(local[inside] // VOXEL, shape - 1).astype(int)
        found += [(b, int(voxel)) for voxel in np.ravel_multi_index(index.T, shape)]
    return sorted(found)


def _found(
    image: RangeImage, pose: Floats, motion: Motion, age: float, boxes: _Boxes, floor: float
) -> list[tuple[int, int]]:
    found = voxels_in_boxes(image, pose, np.linalg.inv(pose), motion, age, *boxes, floor)
    assert (np.diff(found[0]) >= 0).all()
    return sorted((int(b), int(voxel)) for b, voxel in found.T)


@pytest.mark.parametrize(
    ("speed", "turn_rate"), [(0.0, 0.0), (32.0, 0.0), (-25.0, 0.5), (0.0, 2.5), (12.0, -2.5)]
)
@pytest.mark.parametrize("away", [1.5, 4.0, 9.0, 30.0])
def test_voxels_are_those_in_which_some_ray_ends(
    away: float, speed: float, turn_rate: float
) -> None:
    rng = np.random.default_rng(int(away * 10))
    motion, some = (speed, turn_rate, 0.1), 0
    for number in range(6):
        pose, age = tilted_pose(rng), float(rng.uniform(-0.3, 0.3))
        # Two boxes, the first one often where the head's turn ends.
        bearing = np.array([np.pi + rng.normal(0.0, 0.1), rng.uniform(-3.0, 3.0)])
        bearing += np.arctan2(pose[1, 0], pose[0, 0])
        centre = np.stack([np.cos(bearing), np.sin(bearing), np.zeros(2)], axis=1) * away
        centre += pose[:3, 3] + [0.0, 0.0, rng.choice([-1.7, -0.6, 0.9])]
        boxes = _boxes(
            rng.uniform(-25, 25, (2, 2)) * (number % 2),
            centre - np.array([0.0, 0.0, 0.2]) * rng.random(),
            rng.uniform(-3.1, 3.1, 2),
            rng.uniform((0.4, 0.3, 0.3), (2.2, 1.1, 1.0), (2, 3)),
            int(number == 3),
        )
        image = image_of(*_seen_of(rng, boxes, pose, motion, age, 50), motion)
        floor = float(rng.choice([0.0, 0.35]))
        judged = _judged(image, pose, motion, age, boxes, floor)
        assert _found(image, pose, motion, age, boxes, floor) == judged
        some += len(judged)
    assert some > 50


def test_a_view_of_few_rows_shows_no_rays_of_others() -> None:
    pose, motion = np.eye(4), (0.0, 0.0, 0.1)
    elevation = np.linspace(-0.3, 0.3, 61)
    directions = np.stack([np.zeros(61), elevation], axis=1)
    boxes = _boxes(np.zeros((1, 2)), np.array([[8.0, 0, -4.0]]), np.zeros(1), np.full((1, 3), 4.0))
    full = image_of(directions, np.full(61, 7.0), motion)
    low, high = -20 * np.radians(0.3), 30 * np.radians(0.3)
    few = full._replace(lowest=low, highest=high)
    assert len(_found(full, pose, motion, 0.0, boxes, 0.0)) == 61
    assert len(_found(few, pose, motion, 0.0, boxes, 0.0)) == np.sum(
        (elevation > low) & (elevation < high)
    )


def test_more_rays_than_the_first_memory_holds() -> None:
    pose, motion = np.eye(4), (0.0, 0.0, 0.0)
    rng = np.random.default_rng(0)
    directions = rng.uniform(-0.1, 0.1, (1300, 2)) + np.repeat([[0.0, 0.0], [2.0, 0.0]], 650, 0)
    middle = 10.0 * np.array([[1.0, 0.0], [np.cos(2.0), np.sin(2.0)]])
    boxes = _boxes(np.zeros((2, 2)), np.c_[middle, [-2.0, -2.0]], np.zeros(2), np.full((2, 3), 2.5))
    image = image_of(directions, np.full(1300, 10.0), motion)
    found = _found(image, pose, motion, 0.0, boxes, 0.0)
    assert len(found) == 1300
    assert found == _judged(image, pose, motion, 0.0, boxes, 0.0)


def test_voxels_without_a_ray_are_not_found() -> None:
    nothing = image_of(np.zeros((0, 2)), np.zeros(0), (0.0, 0.0, 0.1))
    boxes = _boxes(np.zeros((1, 2)), np.array([[5.0, 0, 0]]), np.zeros(1), np.ones((1, 3)))
    assert _found(nothing, np.eye(4), (0.0, 0.0, 0.1), 0.0, boxes, 0.0) == []


def test_places_are_the_middles_of_voxels() -> None:
    rng = np.random.default_rng(5)
    heading, half = rng.uniform(-3, 3, 3), rng.uniform(0.5, 1.5, (3, 3))
    boxes = _boxes(np.zeros((3, 2)), rng.uniform(-9, 9, (3, 3)), heading, half)
    count = np.array([4, 0, 7])
    voxel = np.concatenate([rng.integers(0, boxes.shape[b].prod(), count[b]) for b in range(3)])
    places = np.empty((11, 3))
    fill_places(count, voxel, boxes.centre, boxes.ahead, boxes.half, boxes.shape, places)
    for place, of, number in zip(places, np.repeat(np.arange(3), count), voxel, strict=True):
        index = np.array(np.unravel_index(number, boxes.shape[of]))
        along, across, up = (index + 0.5) * VOXEL - [*half[of, :2], 0.0]
        turned = complex(along, across) * np.exp(1j * heading[of])
        expected = boxes.centre[of] + [turned.real, turned.imag, up]
        assert place == pytest.approx(expected, abs=1e-9)


_NOTHING = image_of(np.zeros((0, 2)), np.zeros(0), (0.0, 0.0, 0.1))
_HALF = np.array([1.2, 0.5, 0.75])
"""Of a box in a circle of 1.3 m, of which 0.01 m more are looked at."""


@pytest.mark.parametrize("bottom", [-1.5, -0.7, 0.2])
@pytest.mark.parametrize("floor", [0.0, 0.3])
def test_cells_of_a_box_are_those_of_a_cylinder_around_it(bottom: float, floor: float) -> None:
    centre = np.array([6.0, 8.0, bottom + TIP])
    found = _cells_of_box(
        _NOTHING, np.eye(4), (0.0, 0.0, 0.1), 0.0, np.zeros(2), centre, _HALF, floor
    )
    side, low, high = np.arcsin(0.131), bottom + floor - 0.01, bottom + 1.51
    lowest = np.arctan2(low, 8.69 if low < 0 else 11.31)
    highest = np.arctan2(high, 8.69 if high > 0 else 11.31)
    azimuth = np.arctan2(8.0, 6.0)
    assert found[:4] == cells_between(azimuth - side, azimuth + side, lowest, highest)
    assert found[4] == pytest.approx(np.hypot(8.69, max(low, -high, 0.0)))
    assert found[5] == pytest.approx(np.hypot(11.31, max(-low, high)))


def test_a_box_around_the_sensor_is_in_all_directions() -> None:
    centre = np.array([0.4, -1.0, -0.5 + TIP])
    _, _, right, left, near, far = _cells_of_box(
        _NOTHING, np.eye(4), (0.0, 0.0, 0.1), 0.0, np.zeros(2), centre, _HALF, 0.0
    )
    assert left - right == 1200
    assert near == 0.0
    assert far == pytest.approx(np.hypot(np.hypot(0.4, 1.0) + 1.31, 1.01))


def test_a_sensor_that_leans_sees_the_top_beside_the_bottom() -> None:
    lean = np.eye(4)
    cos, sin = np.cos(0.2), np.sin(0.2)
    lean[:3, :3] = [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]
    place = np.linalg.inv(lean) @ [10.0, 0.0, TIP - 0.5, 1.0]
    found = _cells_of_box(_NOTHING, lean, (0.0, 0.0, 0.1), 0.0, np.zeros(2), place[:3], _HALF, 0.3)
    radius = 1.31 + 1.5 * sin
    low, high = -0.51 + 0.3 * cos - radius * sin, -0.49 + 1.5 * cos + radius * sin
    near, far, side = 10.0 - radius, 10.0 + radius, np.arcsin(radius / 10.0)
    assert found[:4] == cells_between(-side, side, np.arctan2(low, near), np.arctan2(high, near))
    assert found[4] == pytest.approx(near)
    assert found[5] == pytest.approx(np.hypot(far, max(-low, high)))


@pytest.mark.parametrize(
    ("motion", "velocity"),
    [
        ((20.0, 0.0, 0.1), (0.0, 0.0)),
        ((-20.0, 0.0, 0.1), (3.0, 4.0)),
        ((0.0, 0.0, 0.1), (0.0, -9.0)),
        ((0.0, 3.0, 0.1), (9.0, 12.0)),
        ((4.0, -2.0, 0.1), (9.0, 12.0)),
    ],
)
@pytest.mark.parametrize("ahead", [True, False])
def test_what_moves_is_looked_for_as_far_as_it_gets_meanwhile(
    motion: Motion, velocity: tuple[float, float], ahead: bool
) -> None:
    speed, turn_rate, period = motion
    centre = np.array([10.0 if ahead else -10.0, 0.0, -0.6 + TIP])
    moves = np.array(velocity)
    found = _cells_of_box(_NOTHING, np.eye(4), motion, 0.0, moves, centre, _HALF, 0.0)
    (x, y, _), _, time, doubt = faced(np.eye(4), motion, 0.0, centre, moves)
    away, fast = np.hypot(x, y), abs(speed) + np.hypot(*velocity)
    # Behind, where a turn ends, rays are sent at any time of it; else in a time as long as the head
    # takes from the middle of the box to its side.
    off = period / 2 + abs(time)
    for _ in range(60 if ahead else 0):
        side = np.arcsin((1.31 + fast * off) / away) + abs(turn_rate) * off
        off = side * period / (2 * np.pi) + 2 * doubt
    radius = 1.31 + fast * off
    assert away - radius - 0.02 < found[4] <= away - radius + 1e-9
    side = np.arcsin(radius / away) + abs(turn_rate) * off
    _, _, right, left = cells_between(np.arctan2(y, x) - side, np.arctan2(y, x) + side, 0.0, 0.0)
    assert right - 1 <= found[2] <= right
    assert left <= found[3] <= left + 1
