"""`avsec/GhostObject-v1`: its rules, and that no agent wins it without looking."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import avsec_gym  # noqa: F401
from avsec_gym.attacks.object_injection import GHOSTS, inject_ghosts
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.ghost_place import GhostPlaceEnv
from avsec_gym.envs.ghost_place_vector import GhostPlaceVectorEnv
from avsec_gym.envs.ghost_round import SCENE_SIZE
from avsec_gym.envs.ghost_spots import considered_spots, spots_of
from avsec_gym.envs.place_features import MOST_ROOM, SIZE, PlaceFeatures
from avsec_gym.errors import AvsecError, ConfigurationError
from avsec_gym.geometry import ego_to_camera
from avsec_gym.pipeline import run_episode
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import scene_set

ID = "avsec/GhostObject-v1"
PLACES = 16


def places_in(observation: np.ndarray) -> PlaceFeatures:
    first = SCENE_SIZE + 5
    rows = observation[..., first : first + PLACES * SIZE]
    return PlaceFeatures.decode(rows.reshape(*observation.shape[:-1], PLACES, SIZE))


def pick(place: int) -> np.ndarray:
    return np.where(np.arange(PLACES) == place, 1.0, -1.0).astype(np.float32)


def played(scenarios: Any, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Observations, and whether each place wins, of some episodes; (B, M), (B, PLACES)."""
    envs = GhostPlaceVectorEnv(count, scenarios=scenarios)
    won = []
    for place in range(PLACES):
        observations, _ = envs.reset(seed=seed)
        won.append(envs.step(np.tile(pick(place), (count, 1)))[-1]["is_success"])
    return observations, np.stack(won, axis=1)


@pytest.fixture(scope="module")
def episodes() -> tuple[np.ndarray, np.ndarray]:
    return played({"name": "layouts", "seed": 1, "count": 60}, 400, 5)


def test_one_place_of_a_drawn_scene_wins(episodes: tuple[np.ndarray, np.ndarray]) -> None:
    assert (episodes[1].sum(axis=1) == 1).all()


def test_the_order_of_places_says_nothing(episodes: tuple[np.ndarray, np.ndarray]) -> None:
    share = episodes[1].mean(axis=0)
    # Six standard errors of a share of 1 in PLACES.
    np.testing.assert_allclose(
        share, 1 / PLACES, atol=6 * np.sqrt((PLACES - 1) / PLACES**2 / len(episodes[1]))
    )


def test_rules_that_do_not_look_at_the_objects_win_rarely(
    episodes: tuple[np.ndarray, np.ndarray],
) -> None:
    """Also the best of a grid of points, for each intention, chosen on these very episodes."""
    observations, won = episodes
    positions = places_in(observations).positions
    intention = observations[:, 2:5].argmax(axis=1)

    def rate(distance: np.ndarray, which: Any = slice(None)) -> float:
        best = distance[which].argmin(axis=1)
        return float(won[which][np.arange(len(best)), best].mean())

    goals = observations[:, None, 5:7] * (50.0, 20.0)
    assert rate(np.linalg.norm(positions, axis=-1)) < 0.35
    assert rate(-np.linalg.norm(positions, axis=-1)) < 0.35
    assert rate(np.linalg.norm(positions - goals, axis=-1)) < 0.35
    assert rate(abs(positions[..., 1])) < 0.35
    points = [(x, y) for x in range(4, 22, 2) for y in range(-6, 7)]
    away = [np.linalg.norm(positions - point, axis=-1) for point in points]
    by_intention = [
        max(rate(distance, intention == i) for distance in away) * np.mean(intention == i)
        for i in range(3)
    ]
    # The best of 117 points on few episodes is flattered: 0.35 is asked of held-out ones, by
    # benchmarks/ghost_places.py.
    assert sum(by_intention) < 0.45


def test_objects_tell_which_place_wins(episodes: tuple[np.ndarray, np.ndarray]) -> None:
    """A ghost that wins closes a gap: some real object is beside or before it."""
    observations, won = episodes
    room = places_in(observations).room.min(axis=-1)
    assert room[won].mean() < room[~won].mean() + MOST_ROOM
    assert (room[won] < MOST_ROOM).mean() > 0.5


def compare_with_pipeline(scenes: SceneSet, motion: Motion, planner: str, count: int) -> set[str]:
    """Steps of the environment beside `run_episode` on the same attacked boxes."""
    env = GhostPlaceEnv(scenarios=scenes, planner=planner, motion=motion, queries=PLACES)
    by_id = {scene.id: scene for scene in scenes.labelled}
    outcomes = set()
    for seed in range(count):
        observation, info = env.reset(seed=seed)
        poses = np.column_stack([places_in(observation.astype(float)).positions, np.zeros(PLACES)])
        for place in range(PLACES):
            info = env.step(pick(place))[4]
            one = by_id[info["scenario"]]
            pose = np.round(poses[place])  # Spots are whole metres; the observation has 32 bits.
            believed = inject_ghosts(one.boxes, pose, GHOSTS["car"].dimensions)
            expected = run_episode(
                one, Intention(info["intention"]), believed, motion=motion, planner=env.game.victim
            ).record
            assert info["outcome"] == expected.outcome, (one.id, place)
            np.testing.assert_equal(info["cost"], expected.cost)
            outcomes.add(info["outcome"])
    return outcomes


@pytest.mark.parametrize("motion", [Motion.STATIC, Motion.TRUTH])
@pytest.mark.parametrize("planner", ["astar", "gbfs"])
def test_a_step_is_what_the_pipeline_does(motion: Motion, planner: str) -> None:
    layouts = scene_set("layouts", seed=3, count=30)
    assert compare_with_pipeline(layouts, motion, planner, 6) >= {"safe", "unplanned"}


def test_a_step_is_what_the_pipeline_does_on_real_scenes(shared: Path) -> None:
    every = scene_set(shared / "safety_scenarios")
    some = SceneSet(every.name, every.scenes[::12])
    assert compare_with_pipeline(some, Motion.STATIC, "astar", 6) >= {"safe", "unplanned"}


def test_no_place_blocks_an_empty_road() -> None:
    """A ghost wins only together with what is really there."""
    scenes = SceneSet("empty", tuple(Scene(str(kind), Boxes3D.empty(), kind) for kind in RoadType))
    with pytest.raises(ConfigurationError, match="nothing to attack"):
        GhostPlaceEnv(scenarios=scenes).reset(seed=0)
    env = GhostPlaceEnv(scenarios=scenes, queries=PLACES)
    for kind in RoadType:
        for intention in Intention:
            for seed in range(4):
                env.reset(seed=seed, options={"scenario": str(kind), "intention": str(intention)})
                outcomes = {env.step(pick(place))[4]["outcome"] for place in range(PLACES)}
                assert outcomes == {"safe"}


def test_a_ghost_closes_the_gap_beside_a_parked_car() -> None:
    """Beside a car ahead there is a way on the other side, until a ghost stands there."""
    location, rotation_y = ego_to_camera(np.array([[9.0, -1.6, 0.0]]), 1.65)
    car = Boxes3D(location, np.array([[1.5, 1.7, 4.0]]), rotation_y, np.ones(1), np.array(["Car"]))
    env = GhostPlaceEnv(scenarios=SceneSet("one", (Scene("one", car),)))
    wins = []
    for seed in range(40):
        observation, _ = env.reset(seed=seed, options={"intention": "straight"})
        answers = env._round.answers  # type: ignore[union-attr]
        wins.append(answers.spots.positions[answers.wins])
        where = places_in(observation).positions
        for place in range(PLACES):
            env.reset(seed=seed, options={"intention": "straight"})
            if env.step(pick(place))[-1]["is_success"]:
                assert where[place, 1] > -1.0
    assert len(wins[0])
    assert (wins[0][:, 1] > -1.0).all()


def test_what_the_observation_tells() -> None:
    env = GhostPlaceEnv(queries=2)
    observation, _ = env.reset(seed=3)
    round = env._round
    assert round is not None
    places = places_in(observation)
    spots = round.answers.spots.positions[round.offered]  # type: ignore[attr-defined]
    np.testing.assert_allclose(places.positions, spots, atol=1e-5)
    expected = PlaceFeatures.among(spots, round.poses[:, 0], round.half_sizes)
    np.testing.assert_allclose(places.room, expected.room, atol=1e-5)
    last = observation[-PLACES:]
    assert not last.any()
    observation, *_ = env.step(pick(5))
    assert observation[-PLACES:].tolist() == [float(place == 5) for place in range(PLACES)]
    assert observation[SCENE_SIZE : SCENE_SIZE + 3].sum() == 1
    assert observation[SCENE_SIZE + 4] == 0.5


def test_a_place_with_the_highest_number_gets_the_ghost() -> None:
    env = GhostPlaceEnv()
    env.reset(seed=1)
    one = env.step(np.array([-0.9, -0.2, *[-0.3] * (PLACES - 2)]))
    env.reset(seed=1)
    two = env.step(pick(1))
    np.testing.assert_equal(one[4], two[4])
    np.testing.assert_array_equal(one[0], two[0])


coordinate = st.floats(-15, 15)


@given(st.lists(st.tuples(coordinate, st.floats(-7, 7)), min_size=1, max_size=9), st.data())
def test_features_of_places_go_there_and_back(where: Any, data: st.DataObject) -> None:
    room = np.array([[data.draw(st.floats(0, MOST_ROOM)) for _ in range(4)] for _ in where], float)
    features = PlaceFeatures(np.array(where, float), room)
    again = PlaceFeatures.decode(features.encode())
    np.testing.assert_allclose(again.positions, features.positions, atol=1e-12)
    np.testing.assert_allclose(again.room, features.room, atol=1e-12)


def test_room_is_measured_to_the_sides_of_objects() -> None:
    """A car 4 m long and 2 m wide, 5 m to the left, and one 4 m ahead."""
    place = np.array([[10.0, 0.0]])
    left = PlaceFeatures.among(place, np.array([[10.0, 5.0, 1.0, 0.0]]), np.array([[2.0, 1.0]]))
    np.testing.assert_allclose(left.room, [[4.0, MOST_ROOM, MOST_ROOM, MOST_ROOM]])
    ahead = PlaceFeatures.among(place, np.array([[14.5, 0.0, 0.0, 1.0]]), np.array([[2.0, 1.0]]))
    np.testing.assert_allclose(ahead.room, [[MOST_ROOM, MOST_ROOM, 3.5, MOST_ROOM]])
    nothing = PlaceFeatures.among(place, np.zeros((0, 4)), np.zeros((0, 2)))
    assert (nothing.room == MOST_ROOM).all()


@pytest.mark.parametrize("road_type", list(RoadType))
@pytest.mark.parametrize("intention", list(Intention))
def test_spots_are_of_the_grid_and_enough(road_type: RoadType, intention: Intention) -> None:
    spots = spots_of(road_type, intention)
    known = {tuple(spot) for spot in considered_spots().tolist()}
    assert {tuple(spot) for spot in spots.positions.tolist()} <= known
    assert len(spots) >= 24
    assert np.isfinite(spots.bias).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"places": 1}, "from 2 to 16"),
        ({"places": 17}, "from 2 to 16"),
        ({"places": 4.0}, "from 2 to 16"),
        ({"scenarios": "no such set"}, "no such set"),
        ({"planner": "dijkstra"}, "astar"),
        ({"motion": "guessed"}, "static.*truth"),
        ({"motion": "classifier"}, 'use "static" or "truth"'),
        ({"queries": 0}, "1 or more"),
        ({"price": float("nan")}, "from 0 to 1, got nan"),
    ],
)
@pytest.mark.parametrize("form", [GhostPlaceEnv, GhostPlaceVectorEnv])
def test_wrong_arguments_are_refused(form: Any, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(AvsecError, match=message):
        form(**arguments)


@pytest.mark.parametrize("places", [2, 16])
def test_other_numbers_of_places(places: int) -> None:
    env = gym.make(ID, places=places)
    observation, _ = env.reset(seed=0)
    assert observation.shape == (269 + 7 * places,)
    assert env.action_space.shape == (places,)
    env.step(env.action_space.sample())
