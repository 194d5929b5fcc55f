"""Claims: where rays ended in a region, by the world's own boxes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from avsec_gym.validation.connected.rays.claims import (
    CLEARANCE,
    MARGIN,
    MOST_CLAIMS,
    MOST_VOXELS,
    MOST_VOXELS_OF_ONE,
    VOXEL,
    claim,
    grid_shapes,
)
from avsec_gym.validation.connected.rays.observer import observe
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.rays.world_of_planes import Box, pose_at, scan_of

_BOX: Box = (10.0, 14.0, -1.0, 1.0, 0.0, 1.5)


def _region(x: float, y: float, heading: float = 0.0) -> Regions:
    return Regions(np.array([[x, y, 0.0]]), np.array([[4.0, 2.0, 1.5]]), np.array([heading]))


def test_claimed_voxels_are_those_of_the_sides_that_face_the_sensor() -> None:
    claims = claim(observe(scan_of([_BOX], pose_at(0.0, 0.0))), _region(12.0, 0.0))
    x, y, z = claims.places(_region(12.0, 0.0)).T
    assert len(x) > 30
    # The front, or the roof; a voxel's centre lies within half a voxel of the surface.
    assert ((np.abs(x - 10.0) <= VOXEL / 2 + 1e-9) | (np.abs(z - 1.5) <= VOXEL / 2 + 1e-9)).all()
    assert (np.abs(y) <= 1.0 + VOXEL).all()
    assert (z > CLEARANCE - VOXEL / 2).all()


def test_layers_are_the_heights_at_which_there_are_voxels() -> None:
    region = _region(12.0, 0.0)
    claims = claim(observe(scan_of([_BOX], pose_at(0.0, 0.0))), region)
    heights = np.unique(claims.places(region)[:, 2].round(6))
    assert claims.layers(region).tolist() == [len(heights)]
    assert len(heights) > 3


@pytest.mark.parametrize("heading", [0.4, np.pi / 2, -2.5])
def test_voxels_of_a_turned_region_lie_at_the_same_surface(heading: float) -> None:
    observer = observe(scan_of([_BOX], pose_at(0.0, 0.0)))
    region = _region(11.0, 0.0, heading)
    x, y, z = claim(observer, region).places(region).T
    front = np.abs(x - 10.0) <= VOXEL * np.sqrt(0.5) + 1e-9
    assert len(x) > 10
    assert (front | (np.abs(z - 1.5) <= VOXEL)).all()
    assert (np.abs(y) <= 1.0 + VOXEL).all()


@pytest.mark.parametrize("empty", [0, 1, 2])
def test_regions_in_which_nothing_is_seen_have_no_claim(empty: int) -> None:
    """Whichever of the regions they are, the claims of the others stay theirs."""
    observer = observe(scan_of([_BOX, (10.0, 14.0, 5.0, 7.0, 0.0, 1.5)], pose_at(0.0, 0.0)))
    places = [(12.0, 0.0), (12.0, 6.0)]
    places.insert(empty, (12.0, -12.0))
    one = [_region(x, y) for x, y in places]
    together = Regions(
        np.concatenate([each.centre for each in one]),
        np.concatenate([each.size for each in one]),
        np.concatenate([each.heading for each in one]),
    )
    claims = claim(observer, together)
    seen = [number for number in range(3) if number != empty]
    assert claims.region.tolist() == seen
    for number, count in zip(seen, claims.count.tolist(), strict=True):
        assert count == len(claim(observer, one[number]).voxel)


def test_the_ground_claims_nothing() -> None:
    empty = scan_of([], pose_at(0.0, 0.0))
    assert len(claim(observe(empty), _region(12.0, 0.0))) == 0


def test_a_vehicle_that_drives_and_turns_claims_where_things_are() -> None:
    sweep, region = RollingSweep(15.0, 0.3, 0.1), _region(-8.0, 9.0)
    box: Box = (-10.0, -6.0, 8.0, 10.0, 0.0, 1.5)
    observer = observe(scan_of([box], pose_at(0.0, 0.0), sweep=sweep))
    x, y, z = claim(observer, region).places(region).T
    near = np.minimum(np.abs(y - 8.0), np.abs(x + 6.0)) <= VOXEL
    assert len(x) > 10
    assert (near | (np.abs(z - 1.5) <= VOXEL / 2 + 1e-9)).all()


def test_what_moves_is_claimed_where_it_is_at_the_instant() -> None:
    sweep, region = RollingSweep(0.0, 0.0, 0.1), _region(12.0, 0.0)
    scan = scan_of([_BOX], pose_at(0.0, 0.0), time=0.1, sweep=sweep, velocity=(15.0, 0.0))
    carried = claim(observe(scan), region, np.array([[15.0, 0.0]]))
    left = claim(observe(scan), region)
    assert np.abs(carried.places(region)[:, 0].min() - 10.0) <= VOXEL / 2 + 1e-6
    assert left.places(region)[:, 0].min() > 11.3


def test_a_vehicle_among_regions_without_end_claims_no_more_than_fits() -> None:
    rng = np.random.default_rng(0)
    box = (*_BOX[:4], 0.0, 3.0)
    observer = observe(scan_of([box], pose_at(0.0, 0.0)))
    centre = np.array([12.0, 0.0, 0.0]) + rng.normal(0, 0.1, (300, 3))
    regions = Regions(centre, np.tile([4.0, 2.0, 3.0], (300, 1)), rng.normal(0, 0.1, 300))
    claims = claim(observer, regions)
    assert len(claims) == MOST_CLAIMS
    assert len(claims.voxel) <= MOST_VOXELS
    assert claims.count.max() <= MOST_VOXELS_OF_ONE
    assert (np.diff(claims.region) > 0).all()


@pytest.mark.parametrize(
    ("heading", "speed", "turn_rate"),
    [(0.5, 30.0, 0.6), (2.9, 30.0, 0.6), (0.5, 0.0, 3.0), (-0.9, 0.0, 3.0), (-0.9, 0.0, -3.0)],
)
@pytest.mark.parametrize("velocity", [(0.0, 0.0), (25.0, -8.0)])
def test_no_ray_that_ends_in_a_region_is_passed_over(
    heading: float, velocity: tuple[float, float], speed: float, turn_rate: float
) -> None:
    sweep = RollingSweep(speed, turn_rate, 0.1)
    post: Box = (11.5, 12.5, -0.5, 0.5, 0.0, 1.2)
    scan = scan_of([post], pose_at(20.0, 4.0, heading), time=0.0, sweep=sweep, velocity=velocity)
    region = Regions(np.array([[12.0, 0.0, 0.0]]), np.array([[1.4, 1.2, 1.0]]), np.array([0.2]))
    # All points, where they were at the instant, in the region's grown box.
    places, after = sweep.compensated(scan.points)
    places = places @ scan.pose[:3, :3].T + scan.pose[:3, 3]
    places[:, :2] -= (scan.time + after)[:, None] * velocity
    away = places - region.centre[0]
    along = np.cos(0.2) * away[:, 0] + np.sin(0.2) * away[:, 1]
    across = np.cos(0.2) * away[:, 1] - np.sin(0.2) * away[:, 0]
    sides = region.size[0] + [2 * MARGIN, 2 * MARGIN, MARGIN]
    inside = (np.abs(along) < sides[0] / 2) & (np.abs(across) < sides[1] / 2)
    inside &= (away[:, 2] > CLEARANCE) & (away[:, 2] < sides[2])
    index = np.c_[along + sides[0] / 2, across + sides[1] / 2, away[:, 2]][inside] // VOXEL
    shape = grid_shapes(sides[None])[0]
    voxels = np.unique(index.astype(int) @ [shape[1] * shape[2], shape[2], 1])
    claims = claim(observe(scan), region, np.array([velocity]))
    assert MOST_VOXELS_OF_ONE >= len(voxels) > 5
    assert len(set(claims.voxel) ^ set(voxels)) <= 2  # at the border of two voxels


@pytest.mark.parametrize("pitch", [0.0, 0.09, -0.09])
@pytest.mark.parametrize("away", [3.2, 4.5, 6.0])
def test_a_tilted_sensor_passes_over_no_corner(pitch: float, away: float) -> None:
    # A corner points to the sensor.
    turned = np.arctan2(1.0 + MARGIN, 2.0 + MARGIN)
    pose = pose_at(0.0, 0.0)
    tilt = np.eye(4)
    tilt[:3, :3] = Rotation.from_euler("y", pitch).as_matrix()
    pose = pose @ tilt
    region = Regions(np.array([[away, 0.0, 0.0]]), np.array([[4.0, 2.0, 1.5]]), np.array([turned]))
    # Points just within the corners of the box, as it is grown.
    half = region.size[0] / 2 + MARGIN - 0.003
    sides = np.array([[x, y] for x in (-1, 1) for y in (-1, 1)]) * half[:2]
    cos, sin = np.cos(turned), np.sin(turned)
    world = np.array(
        [
            [away + cos * x - sin * y, sin * x + cos * y, z, 1.0]
            for x, y in sides
            for z in (CLEARANCE + 0.003, 1.697)
        ]
    )
    points = (world @ np.linalg.inv(pose).T)[:, :3].astype(np.float32)
    scan = VehicleScan(np.c_[points, np.full(len(points), 0.5, np.float32)], pose)
    observer = observe(scan)
    # A handful of rays makes no field of view; here it does.
    rows = observer.image._replace(lowest=-np.pi / 4, highest=np.pi / 4)
    claims = claim(replace(observer, image=rows), region)
    assert len(claims.voxel) == len(points)
