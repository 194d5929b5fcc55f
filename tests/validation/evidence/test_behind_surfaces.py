"""Points behind surfaces, against a plain loop, and in a scene whose rays are known."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats
from avsec_gym.perception.depth.lidar import scan_disparity
from avsec_gym.rig import camera_rig
from avsec_gym.validation.evidence.behind_surfaces import (
    AROUND,
    MIN_KNOWN,
    MIN_NEARER,
    MIN_SURROUNDED,
    STEP,
    _from_the_lidar,
    _is_surrounded,
    _seen_from,
    behind_surfaces,
    lidar_eye,
)

HEIGHT, WIDTH = 120, 400
RIG = camera_rig([0.3, 0.7], focal_length=200.0, centre=(200.0, 60.0), size=(WIDTH, HEIGHT))
LEFT, RIGHT = 0, 1
SCALE = RIG.calibration.focal_length(LEFT) * RIG.calibration.baseline(LEFT, RIGHT)
NEAR, FAR, EDGE = 4.0, 20.0, 0.5
"""Metres ahead of the camera: a wall from EDGE metres right of it on, and one behind it."""


def test_as_a_plain_loop_says() -> None:
    random = np.random.default_rng(0)
    calibration = RIG.calibration
    dense = np.full((HEIGHT, WIDTH), SCALE / 15, np.float32)
    dense[10:100, 150:300] = SCALE / random.uniform(3.0, 3.6, (90, 150))
    dense[random.random(dense.shape) < 0.2] = np.nan
    scan = np.full_like(dense, np.nan)
    scan[::5, ::7] = SCALE / random.uniform(2.5, 30.0, scan[::5, ::7].shape)
    projection = calibration.projection(LEFT)
    # The same camera where the LiDAR is.
    lidar = calibration.velodyne_to_camera[:3, 3]
    moved = np.c_[projection[:, :3], -projection[:, :3] @ lidar]

    def seen(v: int, u: int, disparity: float) -> tuple[float, float, float]:
        depth = SCALE / disparity
        place = np.linalg.solve(projection[:, :3], depth * np.array([u, v, 1]) - projection[:, 3])
        a, b, ahead = moved @ [*place, 1.0]
        return b / ahead, a / ahead, SCALE / ahead

    surfaces = np.zeros(dense.shape)
    for v, u in np.argwhere(np.isfinite(dense)):
        row, column, disparity = seen(v, u, dense[v, u])
        for c in (int(np.floor(column)), int(np.floor(column)) + 1):
            if 0 <= round(row) < HEIGHT and 0 <= c < WIDTH:
                surfaces[round(row), c] = max(surfaces[round(row), c], disparity)
    expected = np.zeros(scan.shape, bool)
    for v, u in np.argwhere(np.isfinite(scan)):
        if not dense[v, u] - scan[v, u] > 3:
            continue
        row, column, own = seen(v, u, scan[v, u])
        expected[v, u] = True
        for down, across in (
            ((-1, 1), (-1, 0)),
            ((-1, 1), (0, 1)),
            ((-1, 0), (-1, 1)),
            ((0, 1), (-1, 1)),
        ):
            rows, columns = (
                [round(middle) + step for step in range(AROUND * first, AROUND * last + 1, STEP)]
                for middle, (first, last) in ((row, down), (column, across))
            )
            side = [
                surfaces[r, c] for r in rows for c in columns if 0 <= r < HEIGHT and 0 <= c < WIDTH
            ]
            known = sum(disparity > 0 for disparity in side)
            nearer = sum(disparity > own + max(3.0, MIN_NEARER * own) for disparity in side)
            enough = known >= MIN_KNOWN * len(rows) * len(columns)
            expected[v, u] &= enough and nearer >= MIN_SURROUNDED * known
    found = behind_surfaces(scan, dense, lidar_eye(calibration, LEFT, SCALE))
    np.testing.assert_array_equal(found, expected)
    assert 20 < found.sum() < 0.8 * np.isfinite(scan).sum()


_MOVED = [
    (0.01, 0.007, 0.0),
    (0.4, 0.0, 0.0),
    (-0.4, 0.1, 0.0),
    (0.0, 0.5, -0.3),
    (0.0, -0.5, 0.2),
    (0.1, 0.2, 2.0),
]
"""Places of a LiDAR to the right of, below and before the camera, metres."""


@pytest.mark.parametrize("place", _MOVED)
def test_each_pixel_of_the_lidars_view_has_the_nearest_surface(
    place: tuple[float, float, float],
) -> None:
    focal, u, v, scale = 20.0, 8.5, 5.25, 12.0
    random = np.random.default_rng(3)
    dense = random.uniform(2.0, 8.0, (11, 17)).astype(np.float32)
    dense[random.random(dense.shape) < 0.5] = np.nan
    dense[4, 3], dense[7, 9], dense[8, 2] = 0.0, -2.0, 0.005
    optics = np.array([[focal, 0, u], [0, focal, v], [0, 0, 1]])
    expected = np.zeros(dense.shape)
    for row, column in np.argwhere(dense > 0.01):
        seen = np.linalg.inv(optics) @ [column, row, 1] * scale / dense[row, column] - place
        if seen[2] <= 0.1:
            continue
        a, b, ahead = optics @ seen
        for c in (int(np.floor(a / ahead)), int(np.floor(a / ahead)) + 1):
            if 0 <= round(b / ahead) < 11 and 0 <= c < 17:
                at = round(b / ahead), c
                expected[at] = max(expected[at], scale / ahead)
    found = _from_the_lidar(dense, np.array([focal, u, v, *place, scale]))
    assert found == pytest.approx(expected, rel=1e-5)
    assert (expected > 0).sum() > 10


def test_what_is_beside_or_behind_the_lidar_is_seen_nowhere() -> None:
    eye = np.array([20.0, 8.0, 5.0, 0.0, 0.0, 3.0, 12.0])
    assert _seen_from(5, 8, 3.0, eye) == (5.0, 8.0, 1.0)
    # Four metres ahead of the camera and one ahead of the LiDAR: four times as far off the axis.
    assert _seen_from(7, 5, 3.0, eye) == (13.0, -4.0, 1.0)
    for disparity in (3.9, 4.0, 6.0):
        row, column, _ = _seen_from(5, 8, disparity, eye)
        assert row < -1e5 > column
    row, column, ahead = _seen_from(5, 8, 3.85, eye)
    assert (row, column, ahead) == pytest.approx((5.0, 8.0, 12.0 / 3.85 - 3.0))


@pytest.mark.parametrize("shape", [(36, 41), (44, 37), (20, 60)])
def test_a_place_is_surrounded_where_enough_of_each_side_is_nearer(shape: tuple[int, int]) -> None:
    random, answers = np.random.default_rng(shape[0]), []
    for _ in range(40):
        row, column = int(random.integers(8, shape[0] - 8)), int(random.integers(10, 28))
        # About as much is known, and nearer, as has to be.
        nearer, known = random.uniform(0.88, 0.99), random.uniform(0.65, 1.1)
        surfaces = np.where(random.random(shape) < nearer, 6.5, 0.5).astype(np.float32)
        surfaces[random.random(shape) < 0.1] *= np.float32(0.99)
        surfaces[random.random(shape) > known] = 0.0
        least = float(random.choice([6.0, 6.45]))
        sides = []
        for rows, columns in (
            ((-16, 16), (-16, 0)),
            ((-16, 16), (0, 16)),
            ((-16, 0), (-16, 16)),
            ((0, 16), (-16, 16)),
        ):
            side = [
                float(surfaces[row + n, column + m])
                for n in range(rows[0], rows[1] + 1, 2)
                for m in range(columns[0], columns[1] + 1, 2)
                if 0 <= row + n < shape[0] and 0 <= column + m < shape[1]
            ]
            of_them = [disparity for disparity in side if disparity > 0]
            share = [disparity for disparity in of_them if disparity > least]
            # 17 x 9 pixels are a side.
            sides.append(2 * len(of_them) >= 153 and len(share) >= 0.9 * len(of_them))
        assert _is_surrounded(surfaces, row, column, least) == all(sides)
        answers.append(all(sides))
    assert 2 <= sum(answers) <= 38


def test_a_place_is_surrounded_by_what_is_known_on_half_of_each_side() -> None:
    surfaces = np.full((33, 33), 9.0, np.float32)
    assert _is_surrounded(surfaces, 16, 16, 8.99)
    # Equally near is not nearer.
    assert not _is_surrounded(surfaces, 16, 16, 9.0)
    # Of 9 x 17 pixels that are looked at above, 5 x 17 are known, then 4 x 17.
    surfaces[:8] = 0.0
    assert _is_surrounded(surfaces, 16, 16, 8.0)
    surfaces[8] = 0.0
    assert not _is_surrounded(surfaces, 16, 16, 8.0)


def seen_along(rays: Floats, origin: Floats) -> Floats:
    """Where rays from a place meet one of the walls, all in the left camera's frame, (N, 3)."""
    near = origin + rays * ((NEAR - origin[2]) / rays[:, 2:])
    far = origin + rays * ((FAR - origin[2]) / rays[:, 2:])
    return np.where(near[:, :1] > EDGE, near, far)


@pytest.fixture(scope="module")
def dense() -> np.ndarray:
    """What the left camera sees, near things seven pixels wider, as matchers make them."""
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    rays = np.stack([(u - 200) / 200, (v - 60) / 200, np.ones(u.shape)], -1).reshape(-1, 3)
    depth = seen_along(rays, np.zeros(3))[:, 2].reshape(u.shape)
    return cv2.dilate((SCALE / depth).astype(np.float32), np.ones((15, 15)))


def scan_of(places: Floats, calibration: Calibration) -> np.ndarray:
    """As disparity, of points in the left camera's frame."""
    projection = calibration.projection(LEFT)
    in_rig = places - np.linalg.solve(projection[:, :3], projection[:, 3])
    points = np.c_[in_rig, np.ones(len(places))] @ calibration.camera_to_velodyne.T
    return scan_disparity(points.astype(np.float32), calibration, (HEIGHT, WIDTH), (LEFT, RIGHT))


def test_what_the_lidar_sees_past_an_edge_is_not_behind_it(dense: np.ndarray) -> None:
    eye = lidar_eye(RIG.calibration, LEFT, SCALE)
    assert eye.place == pytest.approx([-0.3, -0.08, -0.27], abs=0.05)
    # The whole turn, as far as the camera sees it.
    across, down = np.meshgrid(np.linspace(-1, 1, 700), np.linspace(-0.25, 0.25, 60))
    rays = np.stack([across, down, np.ones(across.shape)], -1).reshape(-1, 3)
    places = seen_along(rays, eye.place)
    scan = scan_of(places, RIG.calibration)
    # The camera is right of the LiDAR: to it, some of these points lie behind the near wall.
    past_the_edge = np.isfinite(scan) & (dense - scan > 3)
    assert past_the_edge.sum() > 100
    assert not behind_surfaces(scan, dense, eye).any()


def test_what_no_beam_reaches_is_behind(dense: np.ndarray) -> None:
    eye = lidar_eye(RIG.calibration, LEFT, SCALE)
    x, y = np.meshgrid(np.linspace(2.5, 5.0, 60), np.linspace(-1.0, 1.0, 30))
    patch = np.stack([x, y, np.full(x.shape, 8.0)], -1).reshape(-1, 3)
    scan = scan_of(patch, RIG.calibration)
    points = np.isfinite(scan)
    found = behind_surfaces(scan, dense, eye)
    assert found.sum() > 0.9 * points.sum()
    assert not found[~points].any()
    # Drawn before the wall, it is not behind it; unknown surfaces hide nothing.
    before = scan_of(patch * [0.375, 0.375, 0.375], RIG.calibration)
    assert not behind_surfaces(before, dense, eye).any()
    assert not behind_surfaces(scan, np.full_like(dense, np.nan), eye).any()
