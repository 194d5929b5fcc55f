"""What holds for every environment of the catalogue."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import warnings
from collections.abc import Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec, load_env_creator
from gymnasium.utils.env_checker import check_env as gymnasium_check_env
from stable_baselines3.common.env_checker import check_env as sb3_check_env

import avsec_gym
from avsec_gym.errors import ConfigurationError
from avsec_gym.registration import CATALOGUE, register_environments

pytestmark = pytest.mark.usefixtures("small_suite")
SUPERSEDED = {"avsec/GhostObject-v0"}
"""Stay registered; Gymnasium points to the newer version."""

IDS = [entry.id for entry in CATALOGUE]
every_id = pytest.mark.parametrize("id", IDS)

COMMON_INFO = {
    "planned": bool,
    "success": bool,
    "collision": bool,
    "safe": bool,
    "is_success": bool,
    "cost": float,
    "path_length": float,
    "smallest_distance": float,
    "cost_sm1": float,
    "outcome": str,
    "scenario": str,
    "intention": str,
}
CONNECTED = {"avsec/ConnectedValidation-v0", "avsec/ConnectedSpoofing-v0"}
ONE_STEP = {
    "avsec/DetectorBenchmark-v0",
    "avsec/SensorIdentification-v0",
    "avsec/ConnectedValidation-v0",
}
ONE_QUERY = {entry.id for entry in CATALOGUE if entry.max_episode_steps == 1}
"""Gymnasium's time limit counts the one query, too."""
ATTACKS_IMAGES = {"avsec/PerturbationAttack-v0", "avsec/PatchAttack-v0", "avsec/FaculaAttack-v0"}
ATTACKS_SENSORS = {"avsec/LidarSpoofing-v0", *ATTACKS_IMAGES}
WITHOUT_A_DRIVE = {"avsec/SensorIdentification-v0", *CONNECTED}
HAS_IMAGES = {
    "avsec/DetectorBenchmark-v0",
    "avsec/SensorIdentification-v0",
    *ATTACKS_SENSORS,
}
LOADS = {
    **{id: ["cv2"] for id in HAS_IMAGES | CONNECTED},
    "avsec/PatchAttack-v0": ["torch", "cv2"],
    # highway-env imports the first two; the world's drives, the last.
    "avsec/ClosedLoop-v0": ["matplotlib", "pygame", "cv2"],
    "avsec/ClosedLoopAttack-v0": ["matplotlib", "pygame"],
}
"""Heavy modules that an environment needs to be played."""
FAMILIES = {"avsec/GhostObject-v1", "avsec/PatchAttack-v0", "avsec/ClosedLoop-v0"}
"""One of those that load the same; the others are tried with the slow tests."""
DRIVES = {"avsec/ClosedLoop-v0", "avsec/ClosedLoopAttack-v0"}
"""Go on over time: other outcomes, and `driving` before the end."""
ENDS_DRIVES = {"goal", "collision", "off_road"}
OUTCOMES_OF_DRIVES = ENDS_DRIVES | {"stopped", "time", "driving", "reset"}
RESERVED = {"episode", "final_obs", "final_info", "terminal_observation"}


def arguments(id: str) -> dict[str, Any]:
    """Attackers on sensors play on small frames, against a detector that is quick (conftest.py).

    On such frames, random light raises an alarm nearly always; by E alone, now and then not.
    """
    given: dict[str, Any] = json.loads(os.environ["IMAGE_ATTACK_ARGUMENTS"])
    clean = os.path.join(given["scenarios"], "clean")
    by_error = {"validator": {"name": "thresholds", "criterion": "error"}, "clean": clean}
    if id == "avsec/LidarSpoofing-v0":
        near = {"distances": [5, 15], "bearings": [-0.3, 0.3]}
        return {"scenarios": given["scenarios"], **by_error, **near}
    if id == "avsec/FaculaAttack-v0":
        return given | by_error
    if id == "avsec/ClosedLoopAttack-v0":  # Every drive is made once without the attack.
        return {"scenarios": {"source": "layouts", "count": 4}}
    return given if id in ATTACKS_IMAGES else {}


def make(id: str, **more: Any) -> gym.Env[Any, Any]:
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*is out of date", DeprecationWarning)
        return gym.make(id, **arguments(id), **more)


@pytest.fixture(params=IDS)
def env(request: pytest.FixtureRequest) -> Iterator[gym.Env[Any, Any]]:
    made = make(request.param)
    yield made
    made.close()


def play(env: gym.Env[Any, Any], seed: int, steps: int | None = None) -> Iterator[Any]:
    """Everything that comes out of some episodes with seeded random actions."""
    if steps is None:
        steps = 2 if env.spec.id in CONNECTED else 4 if env.spec.id in HAS_IMAGES else 25  # type: ignore[union-attr]
    env.action_space.seed(seed)
    observation, info = env.reset(seed=seed)
    yield observation, info
    for _ in range(steps):
        action = env.action_space.sample()
        result = env.step(action)
        yield result
        if result[2] or result[3]:
            yield env.reset()


def arrays(observation: Any) -> list[np.ndarray]:
    """An observation's arrays: one, or those of a dictionary."""
    return list(observation.values()) if isinstance(observation, dict) else [observation]


def add(code: Any, parts: Any) -> None:
    for array in arrays(parts[0]):
        code.update(array.tobytes())
    code.update(repr(parts[1:]).encode())


def digest(env: gym.Env[Any, Any], seed: int) -> str:
    code = hashlib.sha256()
    for parts in play(env, seed):
        add(code, parts)
    return code.hexdigest()


@every_id
def test_gymnasiums_checker_has_nothing_to_say(
    id: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also the human mode is tried, in a window that is not shown."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    made = make(id, disable_env_checker=True)
    skip = "pygame" not in sys.modules and not _has_pygame()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gymnasium_check_env(made.unwrapped, skip_render_check=skip)
    made.close()


def _has_pygame() -> bool:
    import importlib.util

    return importlib.util.find_spec("pygame") is not None


@every_id
def test_stable_baselines3s_checker_has_nothing_to_say(id: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sb3_check_env(make(id))
        sb3_check_env(make(id, render_mode="rgb_array", disable_env_checker=True))


@every_id
def test_the_spec_survives_json(id: str) -> None:
    made = make(id)
    spec = EnvSpec.from_json(made.spec.to_json())  # type: ignore[union-attr]
    again = gym.make(spec)
    assert digest(again, 3) == digest(made, 3)
    json.loads(gym.spec(id).to_json())


def test_the_same_seed_is_the_same_episode(env: gym.Env[Any, Any]) -> None:
    first = digest(env, 5)
    digest(env, 6)
    assert digest(env, 5) == first
    assert digest(make(env.spec.id), 5) == first  # type: ignore[union-attr]
    assert digest(env, 6) != first


@pytest.fixture(scope="module")
def played_elsewhere() -> dict[str, str]:
    """The digests of all environments' episodes in one other process."""
    program = (
        "import json; from tests.envs.test_catalogue import IDS, digest, make;"
        "print(json.dumps({id: digest(make(id), 7) for id in IDS}))"
    )
    environment = os.environ | {"PYTHONHASHSEED": "12345"}
    output = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=True,
        env=environment,
        cwd=os.path.dirname(os.path.dirname(os.path.dirname(__file__))),
    ).stdout
    return dict(json.loads(output))


@pytest.mark.slow
@every_id
def test_another_process_plays_the_same_episode(id: str, played_elsewhere: dict[str, str]) -> None:
    assert played_elsewhere[id] == digest(make(id), 7)


def test_info_has_fixed_keys_and_scalars(env: gym.Env[Any, Any]) -> None:
    keys = None
    for parts in play(env, 1):
        info = parts[-1]
        keys = keys or list(info)
        assert list(info) == keys
        assert not RESERVED & set(info)
        assert not any(name.startswith("_") for name in info)
        for name, value in info.items():
            assert type(value) in (bool, int, float, str), (name, type(value))
        for name, kind in COMMON_INFO.items():
            assert type(info[name]) is kind, name
        drives = env.spec.id in DRIVES  # type: ignore[union-attr]
        known = OUTCOMES_OF_DRIVES if drives else {"safe", "collision", "unplanned", "reset"}
        assert info["outcome"] in known
        assert (info["outcome"] == "reset") == (len(parts) == 2)
        assert info["safe"] == (info["outcome"] == ("goal" if drives else "safe"))
        assert info["collision"] == (info["outcome"] == "collision")
        assert info["planned"] == info["success"] == (info["safe"] or info["collision"])
        if env.spec.id not in WITHOUT_A_DRIVE | DRIVES:  # type: ignore[union-attr]
            for name in ("cost", "path_length", "smallest_distance", "cost_sm1"):
                assert np.isnan(info[name]) == (not info["planned"])
            assert (info["smallest_distance"] == 0) == info["collision"] or not info["planned"]
        assert info["intention"] in ("left", "straight", "right")


@pytest.mark.slow
def test_what_a_step_returns_are_plain_types(env: gym.Env[Any, Any]) -> None:
    endings = set()
    quick = env.spec.id not in ONE_STEP | ATTACKS_SENSORS | CONNECTED  # type: ignore[union-attr]
    steps = (
        400 if quick else 3 if env.spec.id in ONE_STEP else 12 if env.spec.id in CONNECTED else 40
    )  # type: ignore[union-attr]
    for parts in play(env, 2, steps):
        if len(parts) == 5:
            _, reward, terminated, truncated, info = parts
            assert type(reward) is float
            assert type(terminated) is bool
            assert type(truncated) is bool
            ends = info["is_success"] or env.spec.id in ONE_STEP  # type: ignore[union-attr]
            if env.spec.id in DRIVES:  # type: ignore[union-attr]
                ends = info["outcome"] in ENDS_DRIVES
            budget = env.spec.max_episode_steps  # type: ignore[union-attr]
            assert terminated == (ends or truncated if budget else ends)
            endings.add((terminated, truncated))
    every = {(False, False), (True, False)}
    if env.spec.id in ONE_STEP | ONE_QUERY:  # type: ignore[union-attr]
        every = {(True, env.spec.id in ONE_QUERY)}  # type: ignore[union-attr]
    assert every <= endings


def test_observations_are_finite_in_the_space_and_not_shared(env: gym.Env[Any, Any]) -> None:
    seen: list[tuple[np.ndarray, np.ndarray]] = []
    for parts in play(env, 3):
        observation = parts[0]
        assert env.observation_space.contains(observation)
        for array in arrays(observation):
            assert np.isfinite(array).all()
            seen.append((array, array.copy()))
    for i, (one, copy) in enumerate(seen):
        np.testing.assert_array_equal(one, copy)
        assert not any(np.shares_memory(one, other) for other, _ in seen[i + 1 :])


@pytest.mark.slow
def test_writing_into_what_one_got_changes_nothing(env: gym.Env[Any, Any]) -> None:
    clean = digest(env, 4)
    code = hashlib.sha256()
    for parts in play(env, 4):
        add(code, parts)
        for array in arrays(parts[0]):
            array[...] = 7
        parts[-1].clear()
    assert code.hexdigest() == clean


@every_id
def test_the_action_is_left_as_it_was(id: str) -> None:
    made = make(id)
    made.reset(seed=0)
    beyond = 1.0 if isinstance(made.action_space, gym.spaces.MultiBinary) else 3.0
    action = np.full(made.action_space.shape, beyond, np.float32)  # type: ignore[arg-type]
    made.step(action)
    assert (action == beyond).all()


def test_a_superseded_version_points_to_the_newer_one() -> None:
    with pytest.warns(DeprecationWarning, match="is out of date.*v1"):
        gym.make("avsec/GhostObject-v0")


def test_registering_twice_is_harmless() -> None:
    before = dict(gym.registry)
    register_environments()
    gym.register_envs(avsec_gym)
    assert dict(gym.registry) == before


@pytest.mark.slow
@every_id
def test_rendering_shows_something_and_changes_nothing(id: str) -> None:
    plain, shown = make(id), make(id, render_mode="rgb_array")
    steps = 1 if id in ONE_STEP | CONNECTED else 4
    for expected, parts in zip(play(plain, 8, steps), play(shown, 8, steps), strict=True):
        picture = shown.render()
        assert isinstance(picture, np.ndarray)
        assert picture.dtype == np.uint8
        assert picture.ndim == 3
        assert picture.shape[2] == 3
        colours = 3 if id in DRIVES else 50  # highway-env paints in few.
        assert len(np.unique(picture.astype(int) @ (1, 256, 65536))) > colours
        for one, two in zip(arrays(expected[0]), arrays(parts[0]), strict=True):
            np.testing.assert_array_equal(one, two)
        assert repr(expected[1:]) == repr(parts[1:])
    np.testing.assert_array_equal(shown.render(), shown.render())
    shown.close()


def printed_by(program: str, id: str) -> str:
    """What a program prints in a process of its own, warnings being errors."""
    known = ["-W", "ignore::DeprecationWarning"] if id in SUPERSEDED else []
    command = [sys.executable, "-W", "error", *known, "-c", program, id, json.dumps(arguments(id))]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd="/")
    return done.stdout.strip()


@pytest.mark.parametrize(
    "id",
    [pytest.param(id, marks=[] if id in FAMILIES else pytest.mark.slow) for id in IDS],
)
def test_a_fresh_process_knows_the_prefixed_id_and_loads_nothing_heavy(id: str) -> None:
    program = (
        "import json, sys, gymnasium as gym; assert 'avsec_gym' not in sys.modules;"
        "env = gym.make(f'avsec_gym:{sys.argv[1]}', **json.loads(sys.argv[2]));"
        "assert env.reset(seed=0)[1]['outcome'] == 'reset'; env.step(env.action_space.sample());"
        "print([m for m in ('matplotlib', 'torch', 'pygame', 'stable_baselines3', 'cv2')"
        " if m in sys.modules])"
    )
    assert printed_by(program, id) == str(LOADS.get(id, []))


@every_id
def test_an_unknown_render_mode_is_refused(id: str) -> None:
    create = load_env_creator(gym.spec(id).entry_point)  # type: ignore[arg-type]
    with pytest.raises(ConfigurationError, match="rgb_array"):
        create(render_mode="ascii")


@every_id
def test_wrong_actions_are_refused(id: str) -> None:
    made = make(id).unwrapped
    made.reset(seed=0)
    right = np.zeros(made.action_space.shape, np.float32)  # type: ignore[arg-type]
    nan, infinite = right.copy(), right.copy()
    nan[0], infinite[-1] = np.nan, np.inf
    for wrong in (
        right[:-1],
        right[None],
        np.zeros(99),
        nan,
        infinite,
        None,
        "left",
        0.0,
        [[1], 2],
    ):
        with pytest.raises(ConfigurationError, match="action"):
            made.step(wrong)
    assert made.step(right.tolist())[4]["outcome"] != "reset"


@every_id
def test_a_step_before_the_first_reset_is_refused(id: str) -> None:
    made = make(id, disable_env_checker=True)
    with pytest.raises(gym.error.ResetNeeded):
        made.step(made.action_space.sample())
    with pytest.raises(gym.error.ResetNeeded):
        made.unwrapped.step(made.action_space.sample())


@every_id
def test_options_pick_scenario_and_intention(id: str) -> None:
    made, some = make(id), 1 if id in CONNECTED else 2
    # Where roads are the world's own, not every scene has a lane for every intention.
    _, first = made.reset(seed=0, options={"intention": "right"})
    chosen = {"scenario": first["scenario"], "intention": first["intention"]}
    for seed in range(2 * some):
        _, info = made.reset(seed=seed, options=chosen)
        assert {name: info[name] for name in chosen} == chosen
    drawn = {
        made.reset(seed=seed, options={"intention": "right"})[1]["intention"]
        for seed in range(4 * some)
    }
    assert drawn == {"right"}
    intentions = {
        made.reset(seed=seed, options={"scenario": first["scenario"]})[1]["intention"]
        for seed in range(6 * some)
    }
    assert len(intentions) > 1


@every_id
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scenario": "no-such"}, "no-such"),
        ({"intention": "up"}, "left.*straight.*right"),
        ({"scene": "000107"}, "scenario and intention"),
    ],
)
def test_wrong_options_are_refused(id: str, options: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        make(id).reset(seed=0, options=options)


@pytest.mark.slow
@every_id
@pytest.mark.parametrize("mode", ["sync", "vector_entry_point"])
def test_many_at_once(id: str, mode: str) -> None:
    if mode == "vector_entry_point" and gym.spec(id).vector_entry_point is None:
        pytest.skip(f"{id} has no vector entry point of its own")
    vector = gym.make_vec(id, num_envs=3, vectorization_mode=mode, **arguments(id))
    observations, _ = vector.reset(seed=0)
    assert vector.observation_space.contains(observations)
    for _ in range(3 if id in CONNECTED else 15):
        observations, rewards, terminated, truncated, info = vector.step(
            vector.action_space.sample()
        )
        assert vector.observation_space.contains(observations)
        assert rewards.shape == terminated.shape == truncated.shape == (3,)
        assert terminated.dtype == truncated.dtype == bool
        assert set(COMMON_INFO) <= set(info)
    vector.close()


@every_id
@pytest.mark.slow
def test_many_at_once_in_processes_of_their_own(id: str) -> None:
    given = arguments(id)
    vector = gym.make_vec(f"avsec_gym:{id}", num_envs=2, vectorization_mode="async", **given)
    alone = gym.make_vec(id, num_envs=2, vectorization_mode="sync", **given)
    for made in (vector, alone):
        made.action_space.seed(1)
    np.testing.assert_equal(vector.reset(seed=0)[0], alone.reset(seed=0)[0])
    for _ in range(6):
        actions = alone.action_space.sample()
        for one, two in zip(vector.step(actions)[:4], alone.step(actions)[:4], strict=True):
            np.testing.assert_equal(one, two)
    vector.close()


@every_id
@pytest.mark.slow
def test_sb3s_subprocesses_know_the_prefixed_id(id: str) -> None:
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv

    given: dict[str, Any] = {"seed": 3, "env_kwargs": arguments(id)}
    spawned = {"start_method": "spawn"}
    many = make_vec_env(
        f"avsec_gym:{id}", 1, vec_env_cls=SubprocVecEnv, vec_env_kwargs=spawned, **given
    )
    alone = make_vec_env(id, 1, vec_env_cls=DummyVecEnv, **given)
    try:
        np.testing.assert_equal(many.reset(), alone.reset())
        for _ in range(12):
            actions = alone.action_space.sample()[None]
            one, two = many.step(actions), alone.step(actions)
            np.testing.assert_equal(one[0], two[0])
            np.testing.assert_allclose(one[1], two[1], atol=1e-7)  # SB3's own has 32 bits.
            np.testing.assert_array_equal(one[2], two[2])
            for info, ended in zip(one[3], one[2], strict=True):
                assert ("episode" in info) == bool(ended)
    finally:
        many.close()
