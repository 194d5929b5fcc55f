"""Motion primitives: physics, chains, dead ends, and the shared reference sets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from avsec_gym.closed_loop.made_primitives import primitives_from
from avsec_gym.errors import ConfigurationError
from avsec_gym.planners.primitive_files import read_primitives
from avsec_gym.planners.primitives import (
    MotionPrimitives,
    generate_primitives,
    standard_primitives,
)
from avsec_gym.planners.vehicle import BMW_320I


def rows(*ends: tuple[float, float, float, float]) -> MotionPrimitives:
    """Primitives of one step with given start speed and angle, end speed and angle."""
    states = np.zeros((len(ends), 2, 5))
    for state, (v0, s0, v1, s1) in zip(states, ends, strict=True):
        state[:, 2], state[:, 4] = (v0, v1), (s0, s1)
    return MotionPrimitives(states, np.ones(len(ends), np.int64))


@pytest.mark.parametrize(
    ("speeds", "count"), [((6.0,), 19), ((6.0, 8.0), None), ((11.0, 13.0), None)]
)
def test_generated_primitives_obey_physics(speeds: tuple[float, ...], count: int | None) -> None:
    primitives = generate_primitives(speeds)
    assert count is None or len(primitives) == count
    x, y, v, heading, steering = np.moveaxis(primitives.states, -1, 0)
    assert not x[:, 0].any()
    assert not y[:, 0].any()
    assert not heading[:, 0].any()
    acceleration, rate = np.diff(v) / 0.1, np.diff(steering) / 0.1
    np.testing.assert_allclose(acceleration, acceleration[:, :1].repeat(5, 1), atol=1e-9)
    np.testing.assert_allclose(rate, rate[:, :1].repeat(5, 1), atol=1e-9)
    assert np.abs(rate).max() <= 0.4 + 1e-9
    lateral = v**2 * np.tan(steering) / BMW_320I.wheelbase
    assert (acceleration[:, :1] ** 2 + lateral**2).max() <= 11.5**2 + 1e-6
    # Mirrored ones belong to the set, too.
    ends = {tuple(np.round(p, 6)) for p in primitives.ends[:, 1:]}
    assert {(-a + 0.0, b, -c + 0.0, -d + 0.0) for a, b, c, d in ends} == {
        (a + 0.0, b, c + 0.0, d + 0.0) for a, b, c, d in ends
    }


def test_primitive_follows_the_differential_equation() -> None:
    primitives = generate_primitives((11.0, 13.0))
    for states in primitives.states[::7]:
        a, rate = (states[-1, 2] - states[0, 2]) / 0.5, (states[-1, 4] - states[0, 4]) / 0.5
        solution = solve_ivp(
            lambda t, s, a=a, rate=rate: [
                s[2] * np.cos(s[3]),
                s[2] * np.sin(s[3]),
                a,
                s[2] * np.tan(s[4]) / BMW_320I.wheelbase,
                rate,
            ],
            (0, 0.5),
            states[0],
            t_eval=np.linspace(0, 0.5, 6),
            rtol=1e-10,
            atol=1e-10,
        )
        np.testing.assert_allclose(states, solution.y.T, atol=1e-6)


def test_a_circle_holds_all_centres_of_a_primitive_and_no_more() -> None:
    """The states are the rear axle's; the vehicle's centre is ahead of it."""
    primitives = generate_primitives((6.0, 8.0))
    x, y, heading = (primitives.states[..., k] for k in (0, 1, 3))
    offset = primitives.vehicle.rear_axle
    centres = np.stack([x + offset * np.cos(heading), y + offset * np.sin(heading)], -1)
    sweep = primitives.arrays.sweep
    farthest = np.linalg.norm(centres - sweep[:, None, :2], axis=-1).max(axis=1)
    # A hundredth of the way is added for the reference mode's rounding.
    way = np.linalg.norm(centres, axis=-1).max(axis=1)
    np.testing.assert_allclose(sweep[:, 2], farthest + 0.01 * way, rtol=1e-12)


def test_a_primitive_knows_the_speeds_on_its_way() -> None:
    for primitives in (generate_primitives((6.0, 8.0)), primitives_from(7.3, 0.1, (6.0, 8.0))):
        velocity = primitives.states[:, 1:, 2]
        np.testing.assert_array_equal(primitives.arrays.sweep[:, 3], velocity.min(axis=1))
        np.testing.assert_array_equal(primitives.arrays.sweep[:, 4], velocity.max(axis=1))


def test_chains_meet_without_drift() -> None:
    """Whatever follows begins at exactly the speed and angle where the one before ended."""
    primitives = generate_primitives((6.0, 8.0))
    before, after = np.nonzero(primitives.follows)
    assert len(before)
    ends, starts = primitives.ends[before], primitives.states[after, 0]
    np.testing.assert_array_equal(ends[:, 2], starts[:, 2])
    np.testing.assert_array_equal(ends[:, 4], starts[:, 4])


def test_successors_of_arrays_are_the_relation() -> None:
    primitives = generate_primitives((6.0, 8.0))
    arrays = primitives.arrays
    for i in range(len(primitives)):
        own = arrays.successors[arrays.first_successor[i] : arrays.first_successor[i + 1]]
        assert own.tolist() == np.nonzero(primitives.follows[i])[0].tolist()
    same = arrays.end_class[:, None] == arrays.end_class[None, :]
    equal_rows = (primitives.follows[:, None, :] == primitives.follows[None, :, :]).all(-1)
    np.testing.assert_array_equal(same, equal_rows)


def test_endless_primitives_lead_into_a_cycle() -> None:
    """Independent argument: endless means that a walk as long as the set is big exists."""
    primitives = rows(
        (1, 0, 2, 0), (2, 0, 1, 0), (3, 0, 4, 0), (4, 0, 5, 0), (6, 0, 3, 0), (7, 0, 1, 0)
    )
    assert primitives.endless.tolist() == [True, True, False, False, False, True]
    for some in (primitives, generate_primitives((6.0, 8.0))):
        walks = np.linalg.matrix_power(some.follows.astype(object), len(some) + 1).sum(axis=1) > 0
        np.testing.assert_array_equal(some.endless, walks.astype(bool))


def test_meeting_tolerance() -> None:
    primitives = rows((1, 0, 2, 0), (2.0099, 0.0099, 1, 0), (2.0101, 0, 1, 0), (2, -0.0101, 1, 0))
    assert primitives.follows[0].tolist() == [False, True, False, False]


def test_start_speed() -> None:
    primitives = rows((1, 0, 1, 0), (3, 0, 3, 0), (9, 0, 4, 0), (3, 0.5, 1, 0))
    assert primitives.nearest_speed(2.0) == 1.0
    assert primitives.nearest_speed(8.0) == 9.0
    assert primitives.nearest_speed(8.0, endless_only=True) == 3.0
    assert primitives.starting_at(3.0).tolist() == [1]
    assert primitives.starting_at(3.0, 0.5).tolist() == [3]
    with pytest.raises(ConfigurationError, match="no primitive can be continued"):
        rows((1, 0, 2, 0)).nearest_speed(1.0, endless_only=True)


def test_extra_start_speed_leads_onto_the_grid() -> None:
    plain = generate_primitives((6.0, 8.0))
    more = generate_primitives((6.0, 8.0), extra_start_speeds=(7.1,))
    new = more.starting_at(7.1)
    assert len(new)
    assert len(more) == len(plain) + len(new)
    assert set(more.ends[:, 2]) == {6.0, 8.0}
    assert not more.follows[:, new].any()
    assert standard_primitives((6.0, 8.0)) is standard_primitives((6.0, 8.0))


@pytest.mark.parametrize("count", [0, 2, -3])
def test_steering_angles_are_an_odd_number(count: int) -> None:
    with pytest.raises(ConfigurationError, match="odd number"):
        generate_primitives((6.0,), steering_angles=count)


def test_no_feasible_primitive_is_an_error() -> None:
    with pytest.raises(ConfigurationError, match="feasible"):
        generate_primitives((60.0,))


@pytest.mark.parametrize(
    ("file", "speeds"), [("street_v6_sa7.xml", (6.0,)), ("highway_v11_13_sa7.xml", (11.0, 13.0))]
)
def test_shared_set_is_reproduced(shared: Path, file: str, speeds: tuple[float, ...]) -> None:
    """Every full-length shared primitive within the friction circle is generated, none besides.

    The shared sets round their angle grid to 1.066/6 = 0.178 rad; they also keep primitives whose
    last state leaves the friction circle, which ours do not.
    """
    theirs = read_primitives(shared / "planning" / "primitives" / file)
    ours = generate_primitives(speeds)
    v, steering = theirs.states[..., 2], theirs.states[..., 4]
    lateral = v**2 * np.tan(steering) / BMW_320I.wheelbase
    acceleration = (v[:, -1] - v[:, 0])[:, None] / 0.5
    inside = (acceleration**2 + lateral**2 <= 11.5**2 + 1e-6).all(axis=1) & (theirs.steps == 5)
    assert inside.sum() >= 14
    distance = np.abs(theirs.states[inside, None] - ours.states[None]).max(axis=(2, 3))
    assert distance.min(axis=1).max() < 1e-4
    assert len(set(distance.argmin(axis=1).tolist())) == inside.sum()
    starts = np.abs(ours.states[:, None, 0, 4] - theirs.states[None, :, 0, 4]).min(axis=1) < 1e-3
    ends = np.abs(ours.ends[:, None, 4] - theirs.ends[None, :, 4]).min(axis=1) < 1e-3
    assert (starts & ends).all()
    assert len(ours) == inside.sum()


def test_what_follows_what_is_a_matter_of_every_pair() -> None:
    primitives = generate_primitives((6.0, 8.0))
    for i, end in enumerate(primitives.ends):
        for j, start in enumerate(primitives.states[:, 0]):
            meets = abs(end[2] - start[2]) < 0.01 and abs(end[4] - start[4]) < 0.01
            assert primitives.follows[i, j] == meets
    _, classes = np.unique(primitives.follows, axis=0, return_inverse=True)
    np.testing.assert_array_equal(primitives.arrays.end_class, classes.reshape(-1))
