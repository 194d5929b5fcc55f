"""Witnesses, held against a judge that looks at every ray of the scan for every voxel."""

import numpy as np
import pytest

from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.rays.claims import CLEARANCE, Claims, claim
from avsec_gym.validation.connected.rays.observer import Observer, observe
from avsec_gym.validation.connected.rays.ray_outcomes import (
    MISSING,
    NEAR,
    OCCLUDED,
    OUTSIDE,
    SUPPORT,
    THROUGH,
)
from avsec_gym.validation.connected.rays.witness import (
    WitnessMargins,
    count_outcomes,
    outcomes,
)
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.sweep import TIP, RollingSweep, from_scan_time
from tests.validation.connected.rays.world_of_planes import Box, pose_at, scan_of

_BOXES: tuple[Box, ...] = (
    (10.0, 14.0, -1.0, 1.0, 0.0, 1.5),
    (12.0, 16.5, 5.0, 7.0, 0.0, 1.8),
    (20.0, 20.4, -4.0, -2.0, 0.0, 1.2),
)
_REGIONS = Regions(
    np.array([[12.0, 0.0, 0.0], [14.0, 6.2, 0.0], [20.0, -3.0, 0.1], [16.0, -1.0, 0.0]]),
    np.array([[4.2, 2.2, 1.6], [4.6, 2.0, 1.8], [0.6, 2.2, 1.3], [3.0, 2.0, 1.5]]),
    np.array([0.1, -0.3, 1.5, 2.0]),
)
_MARGINS = WitnessMargins()


def _claims() -> Claims:
    sweep = RollingSweep(4.0, 0.1, 0.1)
    first = observe(scan_of(_BOXES, pose_at(13.0, -14.0, np.pi / 2), sweep=sweep))
    claims = claim(first, _REGIONS, np.array([[8.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]]))
    assert len(claims) > 1
    return claims


def _witness(heading: float, speed: float, turn_rate: float) -> Observer:
    """It turns, looks later, and at some headings has all of it where its turns end."""
    sweep = RollingSweep(speed, turn_rate, 0.1)
    there = pose_at(25.0, 9.0, heading)
    return observe(scan_of(_BOXES[1:], there, time=0.07, sweep=sweep))


def _judged(
    witness: Observer, claims: Claims, velocity: Floats, since: Floats, margins: WitnessMargins
) -> list[int]:
    """Outcomes by their definition, of the scan's points: no cells, and no bounds of distances."""
    image, sweep = witness.image, witness.scan.sweep
    x, y, z = witness.scan.points[:, :3].astype(float).T
    azimuths, elevations = np.arctan2(y, x), np.arctan2(z - TIP, np.hypot(x, y))
    distance = np.sqrt(x**2 + y**2 + (z - TIP) ** 2)
    # Where each ray ended, in the world.
    when = azimuths * sweep.period / (2 * np.pi)
    turn, ahead = sweep.turn_rate * when, sweep.speed * when
    chord = ahead * np.sinc(turn / 2 / np.pi)
    at_scan = np.c_[
        np.cos(turn) * x - np.sin(turn) * y + chord * np.cos(turn / 2),
        np.sin(turn) * x + np.cos(turn) * y + chord * np.sin(turn / 2),
        z,
        np.ones_like(z),
    ]
    ends = (at_scan @ witness.pose.T)[:, :3]
    to_sensor = np.linalg.inv(witness.pose)
    found = []
    for place, c in zip(claims.places(_REGIONS), claims.of_voxels(), strict=True):
        age, faced = witness.scan.time - since[c], 0.0
        for _ in range(2):
            later = age + faced
            here = to_sensor @ [*(place + later * np.array([*velocity[c], 0.0])), 1.0]
            at = np.arctan2(here[1], here[0]) * sweep.period / (2 * np.pi)
            here[:2] = from_scan_time(here[0], here[1], at, sweep.speed, sweep.turn_rate)
            faced = np.arctan2(here[1], here[0]) * sweep.period / (2 * np.pi)
        x, y, z = here[0], here[1], here[2] - TIP
        azimuth, elevation = np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))
        claimed = np.sqrt(x * x + y * y + z * z)
        low, high = image.lowest + margins.reach, image.highest - margins.reach
        if not low < elevation < high or np.hypot(x, y) > margins.resolved:
            found.append(OUTSIDE)
            continue
        box = int(claims.region[c])
        centre, heading = _REGIONS.centre[box], _REGIONS.heading[box]
        away = np.hypot(*(centre[:2] - witness.pose[:2, 3]))
        around = np.sqrt(2) * margins.around_sigmas * margins.apart(away) + margins.around
        across = min(max(margins.reach, around / claimed), 0.1)
        rise = min(max(margins.reach, margins.around / claimed), 0.1)
        left = (azimuths - azimuth + np.pi) % (2 * np.pi) - np.pi
        left, above = left * np.cos(elevation), elevations - elevation
        off = ends - centre - later * np.array([*velocity[c], 0.0])
        along = np.abs(np.cos(heading) * off[:, 0] + np.sin(heading) * off[:, 1])
        beside = np.abs(np.cos(heading) * off[:, 1] - np.sin(heading) * off[:, 0])
        half = _REGIONS.size[box] / 2 + margins.side
        in_box = (along < half[0]) & (beside < half[1])
        in_box &= (off[:, 2] > 0.7 * CLEARANCE) & (off[:, 2] < 2 * half[2])
        near = (left / across) ** 2 + (above / rise) ** 2 <= 1
        beyond = distance > claimed + margins.beyond
        lower = (np.abs(left) <= across) & (above <= 0)
        lower &= above >= -min(margins.below / claimed, 0.5)
        if not near.any():
            found.append(OUTSIDE if claimed > margins.farthest else MISSING)
        elif (near & in_box).any():
            found.append(SUPPORT)
        elif (distance[near] < claimed - margins.beyond).any():
            found.append(OCCLUDED)
        elif not beyond[near].all() or (lower & in_box).any():
            found.append(NEAR)
        else:
            found.append(THROUGH)
    return found


@pytest.mark.parametrize("heading", [-2.5, 0.6, 2.6])
@pytest.mark.parametrize(("speed", "turn_rate"), [(0.0, 0.0), (30.0, 0.6), (-9.0, -0.4)])
def test_outcomes_are_those_of_all_rays(heading: float, speed: float, turn_rate: float) -> None:
    claims, witness = _claims(), _witness(heading, speed, turn_rate)
    seen = outcomes(witness, claims, _REGIONS, _MARGINS)
    judged = _judged(witness, claims, claims.velocity, np.zeros(len(claims)), _MARGINS)
    # A ray at the very border may fall to either side.
    assert (seen != judged).mean() < 0.01
    assert len(set(judged)) >= 3


@pytest.mark.parametrize("heading", [-2.5, 0.6, 2.6])
def test_outcomes_are_counted_where_enough_support_is(heading: float) -> None:
    claims, witness = _claims(), _witness(heading, 20.0, 0.4)
    random = np.random.default_rng(3)
    velocities = random.uniform(-30.0, 30.0, (12, len(claims), 2))
    velocities[0] = 0.0
    every = np.zeros((*velocities.shape[:2], 3), np.int64)
    for velocity, counts in zip(velocities, every, strict=True):
        outcome = outcomes(witness, claims, _REGIONS, _MARGINS, velocity)
        for kind, each in enumerate((SUPPORT, THROUGH, MISSING)):
            voxels = claims.of_voxels()[outcome == each]
            counts[:, kind] = np.bincount(voxels, minlength=len(claims))
    supported = every[..., 0]
    assert len(np.unique(supported)) > 5
    needed = np.sort(supported, axis=0)[len(every) // 2]
    counted = count_outcomes(witness, claims, _REGIONS, _MARGINS, velocities, needed)
    assert counted.tolist() == np.where((supported >= needed)[..., None], every, 0).tolist()
    counted = count_outcomes(witness, claims, _REGIONS, _MARGINS, velocities)
    assert counted.tolist() == every.tolist()
