from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.people import make_bicycle, make_cyclist, make_person, stride_length
from avsec_gym.world.models.people.bicycle import chosen_bicycle
from avsec_gym.world.models.people.bicycle_parts import WHEEL_RADIUS
from avsec_gym.world.models.people.cyclist import riding
from avsec_gym.world.models.people.gait import walking
from avsec_gym.world.models.people.skeleton import Skeleton, pose
from avsec_gym.world.textures.people import TEXTURES

USUAL = (1.76, 0.66, 0.84)
PHASES = np.linspace(0.0, 1.0, 17)[:-1].tolist()


def random_people() -> list[tuple[Mesh, tuple[float, float, float]]]:
    rng = np.random.default_rng(4)
    people = []
    for number in range(12):
        sizes = rng.normal([1.76, 0.66, 0.84], [0.15, 0.12, 0.2])
        box = (float(sizes[0]), float(max(0.4, sizes[1])), float(max(0.35, sizes[2])))
        phase = float(rng.random())
        people.append((make_person("Pedestrian", box, number, phase, number % 3 > 0), box))
        box = (1.26, 0.6, 0.75)
        people.append((make_person("Person_sitting", box, number), box))
        box = (float(rng.uniform(1.5, 1.9)), 0.6, float(rng.uniform(1.6, 1.95)))
        people.append((make_cyclist(box, number, phase), box))
    return people


@pytest.fixture(scope="module")
def people() -> list[tuple[Mesh, tuple[float, float, float]]]:
    return random_people()


def test_every_figure_fills_the_box(people: list[tuple[Mesh, tuple[float, float, float]]]) -> None:
    for mesh, (height, width, length) in people:
        low, high = mesh.bounds
        np.testing.assert_allclose(low, [-length / 2, -width / 2, 0.0], atol=1e-3)
        np.testing.assert_allclose(high, [length / 2, width / 2, height], atol=1e-3)


def test_budgets(people: list[tuple[Mesh, tuple[float, float, float]]]) -> None:
    for mesh, box in people:
        assert len(mesh.faces) <= (3500 if box[2] > 1.5 else 1500)
    assert len(make_bicycle(0).faces) <= 2500


def test_normals_point_outwards_and_agree_with_the_faces(
    people: list[tuple[Mesh, tuple[float, float, float]]],
) -> None:
    for mesh, _ in people:
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-3)
        corners = mesh.vertices[mesh.faces].astype(float)
        facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        shading = mesh.normals[mesh.faces].sum(axis=1)
        area = np.linalg.norm(facing, axis=1)
        agree = np.sum(facing * shading, axis=1) > 0
        assert area[agree].sum() > 0.97 * area.sum()
        # Enclosed volume is positive when the faces turn their outside outwards.
        assert np.sum(np.cross(corners[:, 0], corners[:, 1]) * corners[:, 2]) > 0


def test_same_person_same_mesh() -> None:
    first, second = (make_person("Pedestrian", USUAL, 7, 0.3, True) for _ in range(2))
    np.testing.assert_array_equal(first.vertices, second.vertices)
    assert first.materials == second.materials
    other = make_person("Pedestrian", USUAL, 8, 0.3, True)
    assert other.materials != first.materials


def test_textures_exist(people: list[tuple[Mesh, tuple[float, float, float]]]) -> None:
    names = {material.texture for mesh, _ in people for material in mesh.materials} - {"plain"}
    for name in names:
        family, _, variant = name.partition("/")
        assert int(variant or 0) < TEXTURES[family].variants


@pytest.mark.parametrize("phase", PHASES)
def test_feet_walk_on_the_ground(phase: float) -> None:
    mesh = make_person("Pedestrian", USUAL, 5, phase, True)
    below = mesh.vertices[mesh.vertices[:, 2] < 0.02]
    assert len(below) >= 3
    assert mesh.vertices[:, 2].min() > -1e-4
    skeleton = pose(walking(phase), 1.76)
    standing = np.argmin(skeleton.legs[:, 2, 2])
    if 0.15 < phase < 0.4:
        assert standing == 0  # the right foot stands while the left one swings


@pytest.mark.parametrize("phase", PHASES)
def test_left_and_right_take_turns(phase: float) -> None:
    now, later = pose(walking(phase), 1.76), pose(walking(phase + 0.5), 1.76)
    flip = np.array([1.0, -1.0, 1.0])
    np.testing.assert_allclose(now.legs[::-1] * flip, later.legs, atol=1e-9)
    np.testing.assert_allclose(now.arms[::-1] * flip, later.arms, atol=1e-9)


def test_arms_swing_against_the_legs() -> None:
    legs, arms = [], []
    for phase in PHASES:
        skeleton = pose(walking(phase), 1.76)
        legs.append(skeleton.legs[0, 2, 0] - skeleton.legs[1, 2, 0])
        arms.append(skeleton.arms[0, 2, 0] - skeleton.arms[1, 2, 0])
    assert np.corrcoef(legs, arms)[0, 1] < -0.8


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("loose", [-0.5, 0.0, 1.0])
def test_joints_bend_as_human_ones(phase: float, loose: float) -> None:
    skeleton = pose(walking(phase), 1.7)
    knees = flexion(skeleton.legs + loose * skeleton.leg_give)
    elbows = flexion(skeleton.arms + loose * skeleton.arm_give)
    assert np.all((knees > -3) & (knees < 100))
    assert np.all((elbows > -3) & (elbows < 100))


@pytest.mark.parametrize("phase", PHASES)
def test_a_cyclist_reaches_pedals_and_handlebar(phase: float) -> None:
    bicycle = chosen_bicycle(1, saddle=0.93)
    rider = riding(bicycle, 1.75, phase)
    knees = flexion(rider.legs)
    assert np.all((knees > 5) & (knees < 125))
    assert bone_lengths(rider) == pytest.approx(bone_lengths(pose(walking(0.0), 1.75)))
    balls = rider.legs[:, 2] - bicycle.pedals(phase)
    assert np.all(np.linalg.norm(balls, axis=1) < 0.17)
    assert np.all(np.linalg.norm(rider.arms[:, 2] - bicycle.hands, axis=1) < 0.12)


def test_wheels_are_round_and_touch_the_ground() -> None:
    mesh = make_cyclist((1.8, 0.6, 1.7), 3, 0.2)
    rubber = [n for n, m in enumerate(mesh.materials) if m.infrared == 0.06]
    tyre = mesh.vertices[np.unique(mesh.faces[np.isin(mesh.material, rubber)])]
    for wheel in (tyre[tyre[:, 0] > 0], tyre[tyre[:, 0] < 0]):
        assert np.ptp(wheel[:, 0]) == pytest.approx(2 * WHEEL_RADIUS, rel=0.04)
        assert np.ptp(wheel[:, 2]) == pytest.approx(2 * WHEEL_RADIUS, rel=0.04)
        assert wheel[:, 2].min() < 0.005
    parked = make_bicycle(2)
    rubber = [n for n, m in enumerate(parked.materials) if m.infrared == 0.06]
    tyre = parked.vertices[np.unique(parked.faces[np.isin(parked.material, rubber)])]
    assert tyre[tyre[:, 0] > 0, 2].min() < 0.02
    assert tyre[tyre[:, 0] < 0, 2].min() < 0.02


def test_taller_people_take_longer_strides() -> None:
    assert 1.2 < stride_length(1.76) < 1.6
    assert stride_length(1.1) < stride_length(1.7)


def test_unknown_people_are_refused() -> None:
    with pytest.raises(ValueError, match="Pedestrian or Person_sitting"):
        make_person("Horse", USUAL, 0)


def flexion(limbs: np.ndarray) -> np.ndarray:
    """Angle between the two bones of limbs, shape (2, 3, 3), degrees."""
    bones = np.diff(limbs, axis=1)
    bones /= np.linalg.norm(bones, axis=-1, keepdims=True)
    return np.degrees(np.arccos(np.clip(np.sum(bones[:, 0] * bones[:, 1], axis=-1), -1, 1)))


def bone_lengths(skeleton: Skeleton) -> np.ndarray:
    limbs = np.stack([skeleton.legs, skeleton.arms])
    return np.linalg.norm(np.diff(limbs, axis=2), axis=-1).ravel()
