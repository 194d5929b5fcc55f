"""Ghosts stay where they were laid; hidden objects stay hidden wherever they go."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.closed_loop.attack.lasting_ghosts import LastingGhosts
from avsec_gym.closed_loop.perception import TruthPerception
from avsec_gym.closed_loop.relative_poses import in_world
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.errors import ConfigurationError
from tests.closed_loop.attack.surroundings import OTHERS, around

START = (0.0, 0.0, 0.0)
DOWN = np.array([-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0])
GHOST = np.array([1.0, -0.5, 0.25, 0.0, -1.0, 0.0, 0.0])
"""15 m ahead, 2 m to the left, along the car."""
HIDE = np.array([-1.0, 0.0, 0.0, 0.0, 1.0, -0.25, 0.5])
"""What is nearest to 20 m ahead, 4 m to the left: actor 9."""


def believed_in_world(attack: LastingGhosts, seen: Surroundings) -> np.ndarray:
    boxes = attack.believed(TruthPerception().perceive(seen), seen).believed
    return in_world(seen.pose, boxes.poses)


def test_a_ghost_stays_at_its_place_while_the_car_drives_and_turns() -> None:
    attack = LastingGhosts()
    assert attack.act(GHOST, around(START)) == 0.5
    for pose in (START, (3.0, 0.5, 0.2), (9.0, -1.0, -0.4)):
        seen = around(pose)
        # Other numbers than those it was laid by do not move it.
        attack.act(GHOST * [1, -1, -1, 1, 1, 1, 1], seen)
        found = believed_in_world(attack, seen)
        assert len(found) == 3
        np.testing.assert_allclose(found[2], [15.0, 2.0, 0.0], atol=1e-9)
        np.testing.assert_allclose(found[:2], OTHERS, atol=1e-9)
    assert attack.facts == {"ghosts": 1, "hidden": 0}


def test_a_ghost_that_is_taken_down_is_gone_and_may_be_laid_anew() -> None:
    attack = LastingGhosts()
    attack.act(GHOST, around(START))
    assert attack.act(DOWN, around(START)) == 0.0
    assert len(believed_in_world(attack, around(START))) == 2
    attack.act(GHOST, around((10.0, 0.0, 0.0)))
    [*_, ghost] = believed_in_world(attack, around(START))
    np.testing.assert_allclose(ghost, [25.0, 2.0, 0.0], atol=1e-9)


def test_a_hidden_object_stays_hidden_when_another_is_nearer() -> None:
    attack = LastingGhosts()
    attack.act(HIDE, around(START))
    moved = np.array([[20.0, 3.5, 0.0], [60.0, 0.0, 0.0]])
    seen = around(START, moved)
    attack.act(HIDE, seen)
    np.testing.assert_allclose(believed_in_world(attack, seen), moved[:1], atol=1e-9)
    np.testing.assert_allclose(attack.state(seen)[5:], [1.0, 60.0 / 50.0, 0.0], atol=1e-9)
    attack.act(DOWN, seen)
    assert len(believed_in_world(attack, seen)) == 2


def test_what_attacker_and_planner_see_agrees() -> None:
    attack = LastingGhosts(hides=0)
    attack.act(GHOST[:4], around(START))
    seen = around((5.0, 0.0, np.pi / 2))
    up, ahead, left, cos, sin = attack.state(seen)
    boxes = attack.believed(TruthPerception().perceive(seen), seen).believed
    assert up == 1.0
    np.testing.assert_allclose(boxes.poses[-1, :2], (50 * ahead, 50 * left), atol=1e-9)
    assert (cos, sin) == pytest.approx((0.0, -1.0), abs=1e-9)


def test_nothing_around_can_be_attacked_too() -> None:
    attack = LastingGhosts(ghosts=2, hides=3)
    alone = around(START, np.zeros((0, 3)))
    assert attack.act(np.ones(attack.action_size), alone) == pytest.approx(2 / 5)
    assert attack.state(alone).shape == (attack.state_size,)
    assert len(believed_in_world(attack, alone)) == 2


def test_wrong_numbers_are_refused() -> None:
    for wrong in ({"ghosts": 0, "hides": 0}, {"ghosts": 17}, {"ahead": (0, 5)}, {"left": (3, 2)}):
        with pytest.raises(ConfigurationError):
            LastingGhosts(**wrong)  # type: ignore[arg-type]
