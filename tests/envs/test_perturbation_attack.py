"""`avsec/PerturbationAttack-v0`: its patterns and budget, and the rules of attacks on images."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from types import ModuleType
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.env_checker import check_env

import avsec_gym  # noqa: F401
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.perturbation_attack import PerturbationAttackEnv
from avsec_gym.envs.sensor_attack_features import GHOSTS, NEAREST, SIZE
from avsec_gym.envs.wave_basis import WaveBasis
from avsec_gym.errors import AvsecError, ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import ego_to_camera, project
from avsec_gym.pipeline import run_episode
from avsec_gym.scenario.frame_scenes import frame_scenes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion

ID = "avsec/PerturbationAttack-v0"


class Watcher:
    """Keeps what it is shown, and reports what it is told."""

    name = "watcher"

    def __init__(self, boxes: Boxes3D | None = None) -> None:
        self.frames: list[SensorFrame] = []
        self.boxes = Boxes3D.empty() if boxes is None else boxes

    def detect(self, frame: SensorFrame) -> Boxes3D:
        self.frames.append(frame)
        return self.boxes


def wall(distance: float) -> Boxes3D:
    """Cars side by side on every lane."""
    poses = np.array([[distance, y, np.pi / 2] for y in np.arange(-40.0, 41.0, 3.9)])
    location, rotation_y = ego_to_camera(poses, 1.65)
    count = len(poses)
    size = np.tile([1.5, 1.6, 4.0], (count, 1))
    return Boxes3D(location, size, rotation_y, np.full(count, 0.9), np.full(count, "Car"))


def random_actions(env: gym.Env[Any, Any], count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1, 1, (count, *env.action_space.shape))  # type: ignore[misc]


@pytest.mark.parametrize("number", range(8))
def test_a_single_wave_has_its_length_and_direction(number: int) -> None:
    """The strongest frequency of its sign is its own."""
    basis = WaveBasis(wavelengths=(16, 64))
    coefficients = np.eye(16)[number]
    pattern = basis.pattern(coefficients, (256, 256)).astype(float)
    spectrum = np.abs(np.fft.fft2(pattern - pattern.mean()))
    down, across = np.fft.fftfreq(256)[np.array(np.unravel_index(spectrum.argmax(), (256, 256)))]
    assert 15 < 1 / np.hypot(across, down) < 68
    assert np.arctan2(down, across) % np.pi == pytest.approx(np.pi * number / 8, abs=0.15) or (
        number == 0 and abs(down) < 0.01
    )


def test_a_pattern_is_the_sign_of_the_sum_of_the_waves() -> None:
    basis, size = WaveBasis(5), (40, 70)
    coefficients = np.random.default_rng(0).normal(size=10)
    total = np.zeros(size)
    for number in range(5):
        length = 12.0 * 5.0 ** ((number * 0.6180339887498949) % 1.0)
        angle = np.pi * number / 5
        v, u = np.mgrid[: size[0], : size[1]]
        phase = 2 * np.pi * (np.cos(angle) * u + np.sin(angle) * v) / length
        total += coefficients[number] * np.cos(phase) + coefficients[number + 5] * np.sin(phase)
    np.testing.assert_array_equal(basis.pattern(coefficients, size), np.sign(total))
    assert not basis.pattern(np.zeros(10), size).any()


@pytest.mark.parametrize("shared", [True, False])
def test_both_images_change_by_the_strength_and_no_more(
    quick: dict[str, Any], shared: bool
) -> None:
    watcher = Watcher()
    env = gym.make(ID, **quick | {"detector": watcher}, epsilon=6, shared=shared)
    assert env.action_space.shape == ((16,) if shared else (32,))
    env.reset(seed=0)
    clean = watcher.frames[-1]
    for action in random_actions(env, 4):
        largest = np.abs(action).max()
        for scale in (1.0, 0.5):
            info = env.step(action * scale / largest)[-1]
            attacked = watcher.frames[-1]
            assert not env.unwrapped.budget.exceeded_by(clean, attacked)  # type: ignore[attr-defined]
            changes = [np.subtract(attacked.image(c), clean.image(c), dtype=int) for c in (2, 3)]
            for camera, change in zip((2, 3), changes, strict=True):
                assert attacked.image(camera).dtype == np.uint8
                assert (np.abs(change) == 6 * scale).mean() > 0.99
            assert info["change"] == 6 * scale
            assert np.array_equal(*changes) == shared


def test_nothing_done_wins_nothing(quick: dict[str, Any]) -> None:
    env = gym.make(ID, **quick)
    for seed in range(6):
        env.reset(seed=seed)
        _, reward, terminated, _, info = env.step(np.zeros(16))
        assert (info["outcome"], terminated, info["is_success"]) == ("safe", False, False)
        assert (info["change"], reward) == (0.0, pytest.approx(-0.02))


def test_a_step_is_what_the_pipeline_does(quick: dict[str, Any], bright_cars: ModuleType) -> None:
    """Detector, threshold, planner and collision check, called by hand on the attacked frame."""
    outcomes, scenes = set(), frame_scenes(quick["scenarios"])
    env = PerturbationAttackEnv(**quick, motion="truth", score_threshold=0.5)
    for scene in scenes.scenes.labelled:
        for intention in Intention:
            env.reset(options={"scenario": scene.id, "intention": str(intention)})
            for action in random_actions(env, 3, seed=int(scene.id)):
                _, reward, terminated, _, info = env.step(action)
                attacked = env.tamper(env.game.situation(scene, intention), action).frame
                boxes = bright_cars.BrightCars().detect(attacked)
                expected = run_episode(
                    scene, intention, boxes[boxes.score >= 0.5], motion=Motion.TRUTH
                )
                assert info["outcome"] == expected.record.outcome
                np.testing.assert_equal(info["cost"], expected.record.cost)
                assert terminated == info["is_success"] == (not expected.record.safe)
                price = 0.02 * (1 + np.abs(action).max())
                assert reward == pytest.approx(float(terminated) - price)
                outcomes.add(info["outcome"])
    assert {"safe", "unplanned"} <= outcomes


def test_what_is_unsafe_by_itself_is_never_drawn_and_gives_no_success(
    quick: dict[str, Any],
) -> None:
    env = PerturbationAttackEnv(**quick | {"detector": Watcher(wall(8.0))})
    with pytest.raises(ConfigurationError, match="nothing to attack"):
        env.reset(seed=0)
    env.reset(options={"scenario": "000001", "intention": "straight"})
    _, reward, terminated, _, info = env.step(np.ones(16))
    assert (info["outcome"], info["is_success"], terminated) == ("unplanned", False, False)
    assert reward == pytest.approx(-0.04)


def test_a_sight_that_the_attack_brings_about_is_a_success(quick: dict[str, Any]) -> None:
    watcher = Watcher()
    env = gym.make(ID, **quick | {"detector": watcher}, price=0.1)
    env.reset(seed=0)
    watcher.boxes = wall(8.0)
    watcher.boxes = replace(watcher.boxes, score=np.full(len(watcher.boxes), 0.29))
    _, _, terminated, _, info = env.step(np.ones(16))
    assert (info["outcome"], info["ghosts"], terminated) == ("safe", 0, False), "not sure enough"
    watcher.boxes = wall(8.0)
    _, reward, terminated, truncated, info = env.step(np.ones(16))
    assert (info["outcome"], info["is_success"]) == ("unplanned", True)
    assert (terminated, truncated, info["ghosts"]) == (True, False, len(watcher.boxes))
    assert reward == pytest.approx(1.0 - 0.2)


def test_the_unattacked_car_is_asked_once_for_each_scene(
    quick: dict[str, Any], bright_cars: ModuleType
) -> None:
    watcher = Watcher()
    env = gym.make(ID, **quick | {"detector": watcher})
    for seed in range(12):
        env.reset(seed=seed)
    assert (
        len(watcher.frames)
        == len({frame.id for frame in watcher.frames})
        <= len(bright_cars.SCENES)
    )


@pytest.mark.parametrize(
    ("arguments", "limit", "end"),
    [
        ({}, 10, (True, True)),
        ({"max_episode_steps": 3}, 3, (False, True)),
        ({"queries": 2}, 2, (True, False)),
        ({"queries": 12, "max_episode_steps": -1}, 12, (True, False)),
    ],
    ids=str,
)
def test_the_budget_terminates_and_a_smaller_limit_truncates(
    quick: dict[str, Any], arguments: dict[str, Any], limit: int, end: tuple[bool, bool]
) -> None:
    env = gym.make(ID, **quick, **arguments)
    env.reset(seed=0)
    ends = [env.step(np.zeros(16))[2:4] for _ in range(limit)]
    assert ends == [(False, False)] * (limit - 1) + [end]


def test_features_tell_the_scene_as_it_is(quick: dict[str, Any], bright_cars: ModuleType) -> None:
    env = gym.make(ID, **quick)
    seen, _ = env.reset(seed=0, options={"scenario": "000000", "intention": "left"})
    assert seen.shape == (SIZE + 16,)
    np.testing.assert_allclose(seen[:5], [6 / 15, 0, 1, 0, 0], atol=1e-6)
    # The goal's middle: 15 m ahead, 3.5 m to the left, on the ground.
    pixels, _ = project(bright_cars.rig().calibration.projection(2), [-3.5, 1.65, 15.0])
    np.testing.assert_allclose(seen[5:7], 2 * pixels / [413, 124] - 1, atol=1e-5)
    assert seen[7] == pytest.approx(2 / 32)
    objects = seen[9 : 9 + 12 * NEAREST].reshape(NEAREST, 12)
    for row, (x, y, heading) in zip(objects, bright_cars.SCENES[0], strict=False):
        expected = [1, x / 50, y / 20, np.cos(heading), np.sin(heading), 0.4, 0.4, 0]
        np.testing.assert_allclose(row[:8], expected, atol=1e-3)
        assert row[10] == row[11] > 0.3, "both cars are found, and nothing has been done yet"
    assert not objects[2:].any()
    assert not seen[9 + 12 * NEAREST : 9 + 12 * NEAREST + 3 * GHOSTS].any(), "nothing else is"
    np.testing.assert_allclose(seen[SIZE - 5 :], [0, 0, 0, 0, 1] + [0] * 16)


def test_features_tell_what_came_of_the_last_query(
    quick: dict[str, Any], bright_cars: ModuleType
) -> None:
    watcher = Watcher()
    env = gym.make(ID, **quick | {"detector": watcher})
    env.reset(options={"scenario": "000001", "intention": "straight"})
    location, rotation_y = ego_to_camera(
        np.array([*bright_cars.SCENES[1], [30.0, -9.0, 0.0]]), 1.65
    )
    size = np.tile([1.5, 1.6, 4.0], (2, 1))
    watcher.boxes = Boxes3D(location, size, rotation_y, np.array([0.2, 0.6]), np.full(2, "Car"))
    action = random_actions(env, 1)[0]
    seen, *_, info = env.step(action)
    first = seen[9:21]
    np.testing.assert_allclose(first[10:], [0.0, 0.2], atol=1e-6)
    ghost = seen[9 + 12 * NEAREST :][:3]
    np.testing.assert_allclose(ghost, [0.6, 30 / 50, -9 / 20], atol=1e-6)
    assert (info["outcome"], info["found"], info["ghosts"]) == ("safe", 0, 1)
    expected = [1, 0, 0, info["cost"] / 3, 0.9]
    np.testing.assert_allclose(seen[SIZE - 5 : SIZE], expected, atol=1e-6)
    np.testing.assert_allclose(seen[SIZE:], action, atol=1e-6)


def test_an_attacker_may_see_a_small_image(quick: dict[str, Any]) -> None:
    env = gym.make(ID, **quick, observation="both")
    check_env(env)
    seen, _ = env.reset(seed=0)
    frame = env.unwrapped._situation.unattacked.frame  # type: ignore[attr-defined]
    assert seen["images"].shape == (48, 160, 3)
    assert seen["images"].mean() == pytest.approx(frame.image(2).mean(), abs=1)
    np.testing.assert_array_equal(env.step(np.ones(16))[0]["images"], seen["images"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"epsilon": 0}, "epsilon"),
        ({"epsilon": 0.4}, "epsilon"),
        ({"epsilon": 256}, "epsilon"),
        ({"waves": 0}, "wave"),
        ({"waves": 1.5}, "wave"),
        ({"wavelengths": [60, 12]}, "the smaller one first"),
        ({"wavelengths": [1, 12]}, "from 2 to 10000"),
        ({"wavelengths": [12]}, "wavelengths"),
        ({"score_threshold": 2}, "threshold"),
        ({"motion": "backwards"}, "motion"),
        ({"queries": 0}, "queries"),
        ({"price": float("nan")}, "price"),
    ],
)
def test_wrong_arguments_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        PerturbationAttackEnv(**arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"detector": "unheard_of"}, "no detector named 'unheard_of'"),
        ({"planner": "unheard_of"}, "no planner named 'unheard_of'"),
        ({"scenarios": "nowhere"}, "nowhere"),
        ({"scenarios": {"folder": "nowhere"}}, "no argument 'folder'"),
    ],
)
def test_names_that_nothing_has_are_refused_at_once(
    quick: dict[str, Any], arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(AvsecError, match=message):
        PerturbationAttackEnv(**quick | arguments)


@pytest.mark.parametrize("id", [ID, "avsec/PatchAttack-v0"])
def test_making_one_loads_nothing_heavy(id: str) -> None:
    """Neither networks nor frames, also with the arguments that it has by itself."""
    program = (
        "import sys, gymnasium as gym; gym.make(f'avsec_gym:{sys.argv[1]}');"
        "print([m for m in ('torch', 'cv2', 'matplotlib') if m in sys.modules])"
    )
    command = [sys.executable, "-W", "error", "-c", program, id]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd="/")
    assert done.stdout.strip() == "[]"


@pytest.mark.slow
@pytest.mark.usefixtures("small_suite")
@pytest.mark.parametrize("id", [ID, "avsec/PatchAttack-v0"])
def test_the_defaults_are_played(id: str) -> None:
    """The detector of the package on the default suite."""
    env = gym.make(id)
    env.reset(seed=0)
    assert env.step(env.action_space.sample())[-1]["outcome"] != "reset"


def test_torch_computes_on_one_thread_while_the_car_looks(quick: dict[str, Any]) -> None:
    import torch

    class Counter(Watcher):
        threads = 0

        def detect(self, frame: SensorFrame) -> Boxes3D:
            self.threads = torch.get_num_threads()
            return super().detect(frame)

    before, counter = torch.get_num_threads(), Counter()
    try:
        torch.set_num_threads(2)
        env = gym.make(ID, **quick | {"detector": counter})
        env.reset(seed=0)
        assert (counter.threads, torch.get_num_threads()) == (1, 2)
    finally:
        torch.set_num_threads(before)
