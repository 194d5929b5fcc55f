"""The collision check against a naive loop over time steps and obstacles."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from avsec_gym.metrics.collision_check import (
    Contact,
    TrajectoryBatch,
    _may_touch,
    _near,
    batch_collides,
    first_contact,
    footprints,
)
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.shapes import Disc, Group, Polygon, Rectangle, Shape

STEPS = 12


def naive(trajectory: np.ndarray, truth: Obstacles, first_step: int = 0) -> Contact | None:
    for step, (x, y, _, heading, _) in enumerate(trajectory, start=first_step):
        cos, sin = np.cos(heading), np.sin(heading)
        car = shapely.Polygon(
            [
                (x + a * cos - b * sin, y + a * sin + b * cos)
                for a, b in ((2.254, 0.805), (-2.254, 0.805), (-2.254, -0.805), (2.254, -0.805))
            ]
        )
        for row, area in enumerate(truth.polygons(step)):
            if area is not None and car.intersects(area):
                return Contact(step, row)
    return None


def random_shape(rng: np.random.Generator) -> Shape:
    x, y, turn = rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5), rng.uniform(-3, 3)
    simple: list[Shape] = [
        Rectangle(rng.uniform(0.5, 5), rng.uniform(0.5, 2)),
        Rectangle(rng.uniform(0.5, 5), rng.uniform(0.5, 2), x, y, turn),
        Disc(rng.uniform(0.2, 2), x, y),
        Polygon(((0.0, 0.0), (3.0, 0.5), (1.0, 0.6), (0.5, 2.5))),
    ]
    kind = int(rng.integers(5))
    return Group(tuple(simple[1:])) if kind == 4 else simple[kind]  # type: ignore[arg-type]


def random_obstacles(rng: np.random.Generator, count: int, spread: float = 25.0) -> Obstacles:
    poses = rng.uniform((-5, -spread / 2, -3.1), (spread, spread / 2, 3.1), (count, 3))
    tracks = np.repeat(poses[:, None], 8, axis=1)
    tracks += np.arange(8)[:, None] * rng.uniform(-1, 1, (count, 1, 3))
    static = rng.random(count) < 0.4
    return Obstacles(
        ids=np.arange(count),
        categories=np.full(count, "car"),
        shapes=tuple(random_shape(rng) for _ in range(count)),
        poses=tracks,
        speeds=np.zeros((count, 8)),
        steps=np.where(static, 1, rng.integers(1, 9, count)),
        first_step=np.where(static, 0, rng.integers(0, 6, count)),
        static=static,
    )


def random_drive(rng: np.random.Generator, length: int = STEPS) -> np.ndarray:
    heading = rng.uniform(-0.5, 0.5) + np.cumsum(rng.uniform(-0.1, 0.1, length))
    away = np.cumsum(np.stack([np.cos(heading), np.sin(heading)], axis=1), axis=0)
    return np.column_stack([away, np.full(length, 10.0), heading, np.zeros(length)])


def test_it_is_what_a_naive_loop_finds() -> None:
    rng = np.random.default_rng(0)
    touched, rows = 0, set()
    for _ in range(150):
        drive = random_drive(rng)
        truth = random_obstacles(rng, int(rng.integers(1, 6)))
        first_step = int(rng.integers(0, 5))
        expected = naive(drive, truth, first_step)
        assert first_contact(drive, truth, BMW_320I, first_step) == expected
        touched += expected is not None
        if expected is not None:
            rows.add(type(truth.shapes[expected.obstacle]).__name__)
    assert 30 < touched < 140
    assert rows == {"Rectangle", "Disc", "Polygon", "Group"}


def standing(x: float, shape: Shape, y: float = 0.0, heading: float = 0.0) -> Obstacles:
    one = Obstacles.rectangles(np.array([[x, y, heading]]), np.ones(1), np.ones(1))
    return Obstacles(
        one.ids, one.categories, (shape,), one.poses, one.speeds, one.steps, one.first_step,
        one.static,
    )  # fmt: skip


@pytest.mark.parametrize(("gap", "touches"), [(0.0, True), (1e-9, False), (-1e-9, True)])
def test_touching_counts(gap: float, touches: bool) -> None:
    stand = np.zeros((1, 5))
    wall = standing(2.254 + 0.5 + gap, Rectangle(1.0, 4.0))
    assert (first_contact(stand, wall, BMW_320I) is not None) == touches


def test_a_shape_off_its_origin_turns_about_its_own_centre() -> None:
    """As commonroad-io has it: the centre is shifted, never turned."""
    ahead = standing(0.0, Rectangle(1.0, 1.0, x=10.0), heading=np.pi)
    drive = np.zeros((20, 5))
    drive[:, 0] = np.arange(20)
    assert first_contact(drive, ahead, BMW_320I) == Contact(8, 0)


def mover(first_step: int = 0) -> Obstacles:
    """Comes along x from 20 m, 1 m a step, in 10 steps, then stays at 10 m."""
    track = np.zeros((1, 11, 3))
    track[0, :, 0] = 20.0 - np.arange(11)
    return Obstacles(
        ids=np.array([1]),
        categories=np.array(["car"]),
        shapes=(Rectangle(1.0, 1.0),),
        poses=track,
        speeds=np.ones((1, 11)),
        steps=np.array([11]),
        first_step=np.array([first_step]),
        static=np.array([False]),
    )


def test_the_last_known_state_is_kept() -> None:
    waits = np.zeros((40, 5))
    waits[20:, 0] = np.arange(20)
    # The car's front reaches 9.5 m at x = 7.246, so at x = 8, 28 steps after the start.
    assert first_contact(waits, mover(), BMW_320I) == Contact(28, 0)


def test_nothing_is_there_before_its_first_step() -> None:
    through = np.zeros((16, 5))
    through[:, 0] = 2.0 * np.arange(16)
    assert first_contact(through, mover(), BMW_320I) == Contact(6, 0)
    # The car stands at 20 m when the mover appears there, at time step 10, and not before.
    assert first_contact(through, mover(first_step=10), BMW_320I) == Contact(10, 0)
    assert first_contact(through[:10], mover(first_step=10), BMW_320I) is None
    # The same if the trajectory itself begins later.
    assert first_contact(through, mover(first_step=13), BMW_320I, 3) == Contact(13, 0)


def test_the_first_of_two_contacts_counts() -> None:
    drive = np.zeros((30, 5))
    drive[:, 0] = np.arange(30)
    cars = Obstacles.rectangles(
        np.array([[20.0, 0, 0], [12.0, 0, 0]]), np.array([4.0, 4.0]), np.array([2.0, 2.0])
    )
    assert first_contact(drive, cars, BMW_320I) == Contact(8, 1)


def test_no_obstacle_and_no_state_are_no_contact() -> None:
    assert first_contact(np.zeros((3, 5)), Obstacles.none(), BMW_320I) is None
    assert first_contact(np.zeros((0, 5)), mover(), BMW_320I) is None


def test_batches_are_judged_like_single_drives() -> None:
    rng = np.random.default_rng(1)
    batch, rows = 60, 4
    lengths = rng.integers(3, STEPS + 1, batch)
    drives = np.stack([random_drive(rng) for _ in range(batch)])
    start = rng.uniform((-5, -12, -3), (25, 12, 3), (batch, rows, 3))
    speed = rng.uniform(0, 15, (batch, rows)) * (rng.random((batch, rows)) < 0.6)
    sizes = rng.uniform((1, 0.5), (6, 2), (batch, rows, 2))
    expected, tracks = [], np.zeros((batch, rows, STEPS, 4))
    for b in range(batch):
        truth = Obstacles.rectangles(
            start[b], sizes[b, :, 0], sizes[b, :, 1], speed[b], last_step=STEPS - 1
        )
        expected.append(first_contact(drives[b, : lengths[b]], truth, BMW_320I) is not None)
        drives[b, lengths[b] :] = drives[b, lengths[b] - 1]
        poses = np.broadcast_to(truth.poses, (rows, STEPS, 3))
        tracks[b] = np.stack(
            [*np.moveaxis(poses[..., :2], -1, 0), np.cos(poses[..., 2]), np.sin(poses[..., 2])], -1
        )
    found = batch_collides(TrajectoryBatch(drives, lengths, tracks, sizes / 2), BMW_320I)
    np.testing.assert_array_equal(found, expected)
    assert 5 < found.sum() < batch - 5


def test_after_its_end_a_drive_of_a_batch_touches_nothing() -> None:
    """The car has arrived: what drives through its last place later is no collision."""
    drive = np.zeros((1, 20, 5))
    track = np.zeros((1, 1, 20, 4))
    track[..., 0], track[..., 2] = 20.0 - np.arange(20), 1.0
    sizes = np.full((1, 1, 2), 0.5)
    early, late = (TrajectoryBatch(drive, np.array([n]), track, sizes) for n in (17, 19))
    assert not batch_collides(early, BMW_320I).any()
    assert batch_collides(late, BMW_320I).all()


def test_obstacles_that_stand_need_one_time_step() -> None:
    drive = np.zeros((2, 10, 5))
    drive[:, :, 0] = np.arange(10)
    track = np.zeros((2, 1, 1, 4))
    track[..., 0], track[..., 2] = np.array([9.0, 15.0])[:, None, None], 1.0
    batch = TrajectoryBatch(drive, np.array([10, 10]), track, np.full((2, 1, 2), 0.5))
    found = batch_collides(batch, BMW_320I)
    assert found.tolist() == [True, False]


def test_footprints_have_the_vehicles_size() -> None:
    corners = footprints(np.array([[1.0, 2.0, 0.0, np.pi / 2, 0.0]]), BMW_320I)
    low, high = corners[0].min(axis=0), corners[0].max(axis=0)
    np.testing.assert_allclose([*low, *high], [0.195, -0.254, 1.805, 4.254])


@pytest.mark.parametrize("moves", [True, False])
def test_near_is_what_may_touch_and_no_more(moves: bool) -> None:
    rng = np.random.default_rng(2)
    drives = np.stack([random_drive(rng) for _ in range(36)])
    lengths = np.array([STEPS, 1, 5, 0, STEPS + 4, 8, STEPS, 3, 2] * 4)
    at = rng.uniform((-4, -8, -3), (16, 8, 3), (36, 5, STEPS if moves else 1, 3))
    poses = np.concatenate([at[..., :2], np.cos(at[..., 2:]), np.sin(at[..., 2:])], axis=-1)
    reach = rng.uniform(0.5, 3.0, (36, 5))
    near = _may_touch(
        drives[:, None, :, [0, 1, 3]], 4.5, 1.6, np.broadcast_to(at, (36, 5, STEPS, 3)),
        reach[..., None],
    )  # fmt: skip
    near &= np.arange(STEPS) < lengths[:, None, None]
    b, i, t = _near(drives, lengths, poses, reach, 2.25, 0.8)
    # Rows in the order of trajectory, step and obstacle; more than the first memory holds.
    expected = np.argwhere(near.swapaxes(1, 2))
    assert np.column_stack([b, t, i]).tolist() == expected.tolist()
    assert 130 < len(b) < 0.6 * near.size


@pytest.mark.parametrize(
    ("x", "y", "near"),
    [(3.2, 0.0, True), (3.3, 0.0, False), (-3.2, 0.0, True), (-3.3, 0.0, False),
     (0.0, 1.75, True), (0.0, 1.85, False), (0.0, -1.75, True), (0.0, -1.85, False)],
)  # fmt: skip
@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_near_is_what_lies_beside_the_vehicle_by_less_than_its_reach(
    x: float, y: float, near: bool, heading: float
) -> None:
    """A vehicle of 4.5 x 1.6 m, and a disc of 1 m around what stands there."""
    place = complex(x, y) * np.exp(1j * heading)
    drive = np.array([[[5.0, -2.0, 0.0, heading, 0.0]]])
    pose = np.array([[[[5.0 + place.real, -2.0 + place.imag, 1.0, 0.0]]]])
    found = _near(drive, np.array([1]), pose, np.ones((1, 1)), 2.25, 0.8)
    assert len(found[0]) == near
