"""What rays meet at claimed voxels, by the definition and a look at every ray."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.claims import CLEARANCE
from avsec_gym.validation.connected.rays.ray_outcomes import (
    MISSING,
    NEAR,
    OCCLUDED,
    OUTSIDE,
    SUPPORT,
    THROUGH,
    WitnessView,
    _distances_of_box,
    fill_counts,
    fill_outcomes,
)
from avsec_gym.validation.connected.sweep import TIP
from tests.validation.connected.rays.rays_by_hand import Motion, faced, image_of, tilted_pose

_MOTIONS: tuple[Motion, ...] = (
    (0.0, 0.0, 0.1),
    (31.0, 0.0, 0.1),
    (-22.0, 0.8, 0.1),
    (9, -2.0, 0.1),
)


def _scene(seed: int, motion: Motion) -> tuple[WitnessView, Floats]:
    """Three claims before a sensor, each with rays of its own kind; and the claims' velocities."""
    rng = np.random.default_rng(seed)
    pose = tilted_pose(rng)
    to_sensor = np.linalg.inv(pose)
    bearing = np.array([np.pi + rng.normal(0.0, 0.08), *rng.uniform(-3.0, 3.0, 2)])
    bearing += np.arctan2(pose[1, 0], pose[0, 0])
    away = rng.permutation([rng.uniform(3.0, 5.0), rng.uniform(8.0, 15.0), rng.uniform(20.0, 35.0)])
    centre = np.stack([np.cos(bearing), np.sin(bearing), np.zeros(3)], axis=1) * away[:, None]
    centre += pose[:3, 3] + [0.0, 0.0, -1.6]
    heading, half = rng.uniform(-3, 3, 3), rng.uniform((0.5, 0.4, 0.5), (2.3, 1.0, 0.9), (3, 3))
    age, velocity = rng.uniform(-0.2, 0.2, 3), rng.uniform(-15, 15, (3, 2)) * rng.integers(0, 2)
    voxels, places = rng.integers(1, 4, 3), []
    around, reach = rng.uniform(0.15, 0.6, 3), float(rng.uniform(0.006, 0.02))
    least_around, beyond = float(rng.uniform(0.1, 0.2)), float(rng.uniform(0.3, 0.6))
    below = float(rng.choice([0.0, rng.uniform(0.4, 2.5), rng.uniform(0.4, 0.8)]))
    directions, distances, flats = [], [], []
    for c in range(3):
        for _ in range(voxels[c]):
            u, v, w = rng.uniform(-1, 1, 3) * half[c]
            turned = complex(u, v) * np.exp(1j * heading[c])
            place = centre[c] + [turned.real, turned.imag, max(w + half[c, 2], 0.4)]
            (x, y, z), *_ = faced(to_sensor, motion, age[c], place, velocity[c])
            flats.append(np.hypot(x, y))
            claimed = float(np.hypot(flats[-1], z - TIP))
            across = min(max(reach, around[c] / claimed), 0.1)
            rise = min(max(reach, least_around / claimed), 0.1)
            azimuth, elevation = np.arctan2(y, x), np.arctan2(z - TIP, flats[-1])
            # Rays in a square somewhat larger than where they are looked at; some kinds lower.
            kind = rng.choice(["support", "through", "missing", "before", "near", "low", "any"])
            count = int(rng.integers(3, 25))
            left, above = rng.uniform(-1.3, 1.3, (2, count)) * [[across], [rise]]
            far = claimed + beyond * rng.uniform(1.01, 9.0, count)
            if kind == "support":
                far[:2] = claimed
            elif kind == "missing":
                above += 2.5 * rise * rng.choice([-1.0, 1.0])
            elif kind == "before":
                far[0] = claimed - beyond * rng.uniform(1.01, 2.0)
            elif kind == "near":
                far[0] = claimed + beyond * rng.uniform(-0.99, 0.99)
            elif kind == "low":
                low = rng.random(count) < 0.5
                above[low] = -min(below / claimed, 0.5) * rng.uniform(0.0, 1.2, low.sum())
                far[low] = claimed + rng.normal(0.0, 0.3, low.sum())
            elif kind == "any":
                far = claimed + rng.normal(0.0, 1.0, count)
            azimuths = azimuth + left / np.cos(elevation)
            directions.append(np.stack([azimuths, elevation + above], axis=1))
            distances.append(far)
            places.append(place)
    view = (-np.pi / 4, np.pi / 4)
    if rng.random() < 0.4:
        edge = np.mean([each[:, 1].mean() for each in directions])
        view = (edge, np.pi / 4) if rng.random() < 0.5 else (-np.pi / 4, edge)
    flat = np.array(flats)
    look = WitnessView(
        image_of(np.concatenate(directions), np.concatenate(distances), motion, view),
        pose,
        to_sensor,
        motion,
        np.array(places),
        voxels,
        age,
        centre,
        np.stack([np.cos(heading), np.sin(heading)], axis=1),
        half,
        around,
        reach,
        least_around,
        beyond,
        below,
        farthest=float(rng.uniform(6.0, 40.0)),
        resolved=float(rng.choice([60.0, rng.uniform(flat.min(), flat.max())])),
    )
    return look, velocity


def _judged(look: WitnessView, velocity: Floats) -> list[int]:
    """The outcome of every voxel."""
    image = look.image
    azimuths, elevations, distances = (
        column.astype(float) for column in (image.azimuth, image.elevation, image.distance)
    )
    ends = image.end.astype(float) @ look.pose[:3, :3].T + look.pose[:3, 3]
    found = []
    for place, c in zip(look.places, np.repeat(np.arange(3), look.voxels), strict=True):
        (x, y, z), later, _, _ = faced(look.to_sensor, look.motion, look.age[c], place, velocity[c])
        flat, up = np.hypot(x, y), z - TIP
        azimuth, elevation, claimed = np.arctan2(y, x), np.arctan2(up, flat), np.hypot(flat, up)
        if not image.lowest + look.reach < elevation < image.highest - look.reach:
            found.append(OUTSIDE)
            continue
        if flat > look.resolved:
            found.append(OUTSIDE)
            continue
        across = np.clip(look.around[c] / claimed, look.reach, 0.1)
        rise = np.clip(look.least_around / claimed, look.reach, 0.1)
        left = np.angle(np.exp(1j * (azimuths - azimuth))) * np.cos(elevation)
        above = elevations - elevation
        off = ends - look.centre[c] - [*(later * velocity[c]), 0.0]
        cos, sin = look.ahead[c]
        along, beside = cos * off[:, 0] + sin * off[:, 1], cos * off[:, 1] - sin * off[:, 0]
        in_box = (abs(along) < look.half[c, 0]) & (abs(beside) < look.half[c, 1])
        in_box &= (off[:, 2] > 0.7 * CLEARANCE) & (off[:, 2] < 2 * look.half[c, 2])
        near = np.hypot(left / across, above / rise) <= 1
        # From the voxel's own height down, straight below it.
        lower = min(look.below / claimed, 0.5)
        middle = elevation - lower / 2
        beside_lower = np.angle(np.exp(1j * (azimuths - azimuth))) * np.cos(middle)
        under = (abs(beside_lower) <= across) & (above <= 0) & (above >= -lower)
        if not near.any():
            found.append(OUTSIDE if claimed > look.farthest else MISSING)
        elif (near & in_box).any():
            found.append(SUPPORT)
        elif (distances[near] < claimed - look.beyond).any():
            found.append(OCCLUDED)
        elif (distances[near] <= claimed + look.beyond).any() or (
            look.below > 0 and (under & in_box).any()
        ):
            found.append(NEAR)
        else:
            found.append(THROUGH)
    return found


@pytest.mark.parametrize("motion", _MOTIONS)
def test_outcomes_are_those_of_a_look_at_every_ray(motion: Motion) -> None:
    kinds: Counter[int] = Counter()
    for seed in range(36):
        look, velocity = _scene(seed, motion)
        result = np.full(len(look.places), -1, np.int8)
        fill_outcomes(look, velocity, result)
        judged = _judged(look, velocity)
        assert result.tolist() == judged, seed
        kinds += Counter(judged)
    assert min(kinds[kind] for kind in range(6)) >= 5


def test_counts_are_those_of_the_outcomes_where_enough_rays_support() -> None:
    rng, refused = np.random.default_rng(0), 0
    for seed in range(28):
        look, velocity = _scene(100 + seed, _MOTIONS[seed % 4])
        velocities = np.stack([velocity, velocity + rng.normal(0.0, 6.0, (3, 2))])
        expected = np.zeros((2, 3, 3), np.int64)
        of_voxels = np.repeat(np.arange(3), look.voxels)
        for s in range(2):
            for c, outcome in zip(of_voxels, _judged(look, velocities[s]), strict=True):
                if outcome in (SUPPORT, THROUGH, MISSING):
                    expected[s, c, outcome] += 1
        # As many as support it, one more, or none.
        needed = expected[0, :, SUPPORT] + rng.integers(-1, 2, 3)
        enough = expected[..., SUPPORT] >= needed
        refused += int((~enough & expected.any(axis=2)).sum())
        counts = np.zeros((2, 3, 3), np.int64)
        fill_counts(look, velocities, needed, counts)
        assert counts.tolist() == np.where(enough[..., None], expected, 0).tolist()
    assert refused > 3


def _alone(**changed: object) -> WitnessView:
    """One voxel 10 m ahead of a sensor that stands at the height of its rays, in a large box."""
    look = WitnessView(
        image_of(np.zeros((0, 2)), np.zeros(0), (0.0, 0.0, 0.1)),
        np.eye(4),
        np.eye(4),
        (0.0, 0.0, 0.1),
        np.array([[10.0, 0.0, TIP]]),
        np.array([1]),
        np.zeros(1),
        np.array([[10.0, 0.0, -1.0]]),
        np.array([[1.0, 0.0]]),
        np.array([[0.5, 1.0, 1.0]]),
        np.array([0.3]),
        reach=0.007,
        least_around=0.1,
        beyond=0.4,
        below=0.5,
        farthest=40.0,
        resolved=50.0,
    )
    return look._replace(**changed)


def _outcome(look: WitnessView) -> int:
    result = np.full(1, -1, np.int8)
    fill_outcomes(look, np.zeros((1, 2)), result)
    return int(result[0])


@pytest.mark.parametrize(
    ("direction", "distance", "outcome"),
    [
        ((0.0, 0.0), 10.0, SUPPORT),
        # The box begins at 9.5 m.
        ((0.0, 0.0), 9.51, SUPPORT),
        ((0.0, 0.0), 9.49, OCCLUDED),
        ((0.0, 0.0), 10.51, THROUGH),
        ((0.0, 0.0), 60.0, THROUGH),
        # 0.3 m to the side and 0.1 m up, at 10 m.
        ((0.0299, 0.0), 10.0, SUPPORT),
        ((0.0301, 0.0), 10.0, MISSING),
        ((0.0, 0.0099), 10.0, SUPPORT),
        ((0.0, 0.0101), 10.0, MISSING),
        ((-0.0299, 0.0), 10.0, SUPPORT),
        ((-0.0301, 0.0), 10.0, MISSING),
        ((0.0, -0.0099), 10.0, SUPPORT),
        ((0.0, -0.0101), 10.0, MISSING),
    ],
)
def test_one_ray(direction: tuple[float, float], distance: float, outcome: int) -> None:
    image = image_of(np.array([direction]), np.array([distance]), (0.0, 0.0, 0.1))
    assert _outcome(_alone(image=image)) == outcome


@pytest.mark.parametrize("distance", [9.61, 10.39])
def test_a_ray_that_ends_beside_the_box_and_not_far_from_the_voxel_decides_nothing(
    distance: float,
) -> None:
    image = image_of(np.zeros((1, 2)), np.array([distance]), (0.0, 0.0, 0.1))
    small = np.array([[0.05, 1.0, 1.0]])
    assert _outcome(_alone(image=image, half=small)) == NEAR
    further = image_of(np.zeros((1, 2)), 10 + 1.1 * (np.array([distance]) - 10), (0.0, 0.0, 0.1))
    expected = OCCLUDED if distance < 10 else THROUGH
    assert _outcome(_alone(image=further, half=small)) == expected


@pytest.mark.parametrize(
    ("lower", "aside", "outcome"),
    [
        # Half a metre, at 10 m, down to which rays in the box are looked for.
        (0.0495, 0.0, NEAR),
        (0.0505, 0.0, THROUGH),
        (0.02, 0.0299, NEAR),
        (0.02, 0.0303, THROUGH),
        (0.02, -0.0303, THROUGH),
    ],
)
def test_rays_over_the_top_of_what_a_lower_one_ends_in(
    lower: float, aside: float, outcome: int
) -> None:
    image = image_of(np.array([[0.0, 0.0], [aside, -lower]]), np.array([20.0, 10.0]), (0, 0, 0.1))
    assert _outcome(_alone(image=image)) == outcome
    assert _outcome(_alone(image=image, below=0.0)) == THROUGH
    # Half a radian is the most.
    steep = image_of(np.array([[0.0, 0.0], [0.0, -0.45]]), np.array([20.0, 10.9]), (0, 0, 0.1))
    tall = {"centre": np.array([[10.0, 0.0, -9.0]]), "half": np.array([[0.5, 1.0, 9.0]])}
    assert _outcome(_alone(image=steep, below=9.0, **tall)) == NEAR


def test_what_no_ray_meets_is_missing_up_to_where_returns_are_sure() -> None:
    assert _outcome(_alone()) == MISSING
    assert _outcome(_alone(farthest=9.99)) == OUTSIDE
    assert _outcome(_alone(resolved=10.01)) == MISSING
    assert _outcome(_alone(resolved=9.99)) == OUTSIDE


@pytest.mark.parametrize(("view", "outcome"), [(0.0069, OUTSIDE), (0.0071, MISSING)])
def test_what_is_near_the_border_of_the_view_is_outside(view: float, outcome: int) -> None:
    nothing = _alone().image
    assert _outcome(_alone(image=nothing._replace(lowest=-view))) == outcome
    assert _outcome(_alone(image=nothing._replace(highest=view))) == outcome


def test_a_box_is_as_far_as_a_sphere_around_it() -> None:
    half, box = np.array([2.0, 1.0, 2.0]), (3.0, 4.0, TIP - 2.0, 1.0, 0.0)
    standing = _distances_of_box(np.eye(4), (0.0, 0.0, 0.1), 0.0, 0.02, box, half)
    assert standing == pytest.approx((5.0 - 3.01, 5.0 + 3.01))
    # Times that are 0.02 s off: the vehicle drives 0.2 m meanwhile, and turns things 8 m away by
    # 0.01 radians.
    driving = _distances_of_box(np.eye(4), (-10.0, -0.5, 0.1), 0.0, 0.02, box, half)
    assert driving == pytest.approx((5.0 - 3.29, 5.0 + 3.29))
    # A fifth of a second later it is 3 m ahead, and its sensor 3 m higher.
    lifted = np.eye(4)
    lifted[2, 3] = -3.0
    ahead = _distances_of_box(lifted, (15.0, 0.0, 0.1), 0.2, 0.0, box, half)
    assert ahead == pytest.approx((5.0 - 3.01, 5.0 + 3.01))
