"""Ghosts land where they are asked for; hidden objects are gone."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.attacks.object_injection import (
    GHOSTS,
    GhostRange,
    RandomGhosts,
    hide_objects,
    inject_ghosts,
)
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import rectangle_polygons
from avsec_gym.world.layouts import generate_layouts

UNIT = st.floats(-1, 1)
EGO = shapely.box(-2.254, -0.805, 2.254, 0.805)
REAL = max((layout.boxes for layout in generate_layouts(20)), key=len)


@given(st.lists(st.tuples(UNIT, UNIT, UNIT, UNIT), min_size=1, max_size=5))
def test_encode_undoes_decode(rows: list[tuple[float, ...]]) -> None:
    actions, ghosts = np.array(rows), GHOSTS["car"]
    on, poses = ghosts.decode(actions)
    again = ghosts.encode(on, poses)
    np.testing.assert_array_equal(again[:, 0] > 0, actions[:, 0] > 0)
    np.testing.assert_allclose(again[:, 1:], actions[:, 1:], atol=1e-12)


@given(st.floats(5, 30), st.floats(-8, 8), st.floats(-np.pi, np.pi), st.booleans())
def test_decode_undoes_encode(x: float, y: float, heading: float, on: bool) -> None:
    ghosts = GHOSTS["car"]
    action = ghosts.encode(np.array([on]), np.array([[x, y, heading]]))
    assert (np.abs(action) <= 1 + 1e-12).all()
    shown, poses = ghosts.decode(action)
    assert shown.tolist() == [on]
    np.testing.assert_allclose(poses, [[x, y, heading]], atol=1e-12)


def test_the_scale_is_as_documented() -> None:
    corners = np.array([[1.0, -1, -1, -1], [-1, 1, 1, 1], [0, 0, 0, 0], [1e-9, 9, -9, 0]])
    on, poses = GHOSTS["car"].decode(corners)
    assert on.tolist() == [True, False, False, True]
    np.testing.assert_allclose(
        poses, [[5, -8, -np.pi], [30, 8, np.pi], [17.5, 0, 0], [30, -8, 0]], atol=1e-12
    )


def test_batches_keep_their_shape() -> None:
    actions = np.random.default_rng(0).uniform(-1, 1, (3, 2, 4))
    on, poses = GHOSTS["car"].decode(actions)
    assert (on.shape, poses.shape) == ((3, 2), (3, 2, 3))
    np.testing.assert_array_equal(poses[2], GHOSTS["car"].decode(actions[2])[1])


@pytest.mark.parametrize("wrong", [(3.0, 3.0), (4.0, 3.0), (float("nan"), 1.0)])
def test_a_range_runs_upwards(wrong: tuple[float, float]) -> None:
    with pytest.raises(ConfigurationError, match="x takes two numbers"):
        GhostRange(x=wrong)


@given(st.floats(5, 30), st.floats(-8, 8), st.floats(-np.pi, np.pi))
def test_ghosts_land_where_asked(x: float, y: float, heading: float) -> None:
    boxes = inject_ghosts(Boxes3D.empty(), np.array([[x, y, heading]]))
    np.testing.assert_allclose(boxes.poses[0, :2], [x, y], atol=1e-12)
    turn = boxes.poses[0, 2] - heading
    assert abs(np.exp(1j * turn) - 1) < 1e-9
    assert boxes.dimensions.tolist() == [list(GHOSTS["car"].dimensions)]
    # In the camera's frame: left is negative x, ahead is z.
    np.testing.assert_allclose(boxes.location[0], [-y, 1.65, x], atol=1e-12)


@given(UNIT, UNIT, UNIT)
def test_ghosts_never_overlap_the_ego_vehicle_at_the_start(x: float, y: float, turn: float) -> None:
    _, poses = GHOSTS["car"].decode(np.array([[1.0, x, y, turn]]))
    (area,) = rectangle_polygons(
        poses, [GHOSTS["car"].dimensions[2]], [GHOSTS["car"].dimensions[1]]
    )
    assert area.distance(EGO) > 0.1


def test_ghosts_come_last_and_the_others_stay() -> None:
    attacked = inject_ghosts(REAL, np.array([[10.0, 1, 0], [20.0, 2, 1]]), score=0.9)
    assert len(attacked) == len(REAL) + 2
    np.testing.assert_array_equal(attacked.location[: len(REAL)], REAL.location)
    np.testing.assert_array_equal(attacked.moving, [*REAL.moving, False, False])
    assert attacked.score[-2:].tolist() == [0.9, 0.9]
    assert attacked.category[-2:].tolist() == ["Car", "Car"]
    assert len(inject_ghosts(REAL, np.zeros((0, 3)))) == len(REAL)


def test_ghosts_join_detections_that_know_nothing_of_motion() -> None:
    detected = inject_ghosts(REAL, np.zeros((0, 3)))
    plain = Boxes3D(
        detected.location, detected.dimensions, detected.rotation_y, detected.score,
        detected.category,
    )  # fmt: skip
    attacked = inject_ghosts(plain, np.array([[10.0, 1, 0]]))
    assert len(attacked) == len(plain) + 1
    assert attacked.moving is None


def test_hidden_objects_are_gone() -> None:
    left = hide_objects(REAL, np.array([0, 2, 2, -1, 999]))
    np.testing.assert_array_equal(left.location, REAL.location[[1, *range(3, len(REAL))]])
    assert len(hide_objects(REAL, np.array([], int))) == len(REAL)
    assert len(hide_objects(Boxes3D.empty(), np.array([0]))) == 0


def test_the_random_attacker_asks_until_it_succeeds_or_its_budget_ends() -> None:
    asked = []

    def stubborn(boxes: Boxes3D) -> bool:
        asked.append(boxes)
        return False

    attacked, queries = RandomGhosts(ghosts=3, queries=6).attack(REAL, stubborn, 0)
    assert (queries, len(asked)) == (6, 6)
    assert attacked is asked[-1]
    assert {len(boxes) for boxes in asked} == {len(REAL) + 3}
    assert len({boxes.location.tobytes() for boxes in asked}) == 6

    answers = iter([False, False, True])
    attacked, queries = RandomGhosts().attack(REAL, lambda boxes: next(answers), 0)
    assert queries == 3


@pytest.mark.parametrize(("name", "least", "most"), [("ghosts", 0, 1000), ("queries", 1, 100_000)])
def test_the_random_attackers_numbers_have_ends(name: str, least: int, most: int) -> None:
    for end, beyond in ((least, least - 1), (most, most + 1)):
        RandomGhosts(**{name: end})
        with pytest.raises(ConfigurationError, match=name):
            RandomGhosts(**{name: beyond})


def test_the_random_attacker_is_seeded() -> None:
    one, two, other, pair = (
        RandomGhosts().attack(REAL, lambda boxes: True, seed)[0].location
        for seed in (1, 1, 2, (0, 1))
    )
    np.testing.assert_array_equal(one, two)
    assert (one != other).any()
    assert (one != pair).any()
