"""`avsec/PatchAttack-v0`: places that can be, what is pasted there, what comes of it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch

import avsec_gym  # noqa: F401
from avsec_gym.attacks.attack import Budget
from avsec_gym.attacks.patch_files import Patch, save_patch
from avsec_gym.attacks.patch_pasting import largest_area
from avsec_gym.attacks.patch_placement import PatchPlace, random_place
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.patch_attack import PatchAttackEnv
from avsec_gym.envs.patch_coding import PatchCoding
from avsec_gym.envs.sensor_attack_features import SIZE
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration
from avsec_gym.rig import kitti_rig

ROOT = Path(__file__).parents[2]
ID = "avsec/PatchAttack-v0"
CALIBRATION, HEIGHT, WIDTH = kitti_rig().calibration, 375, 1242
CODING = PatchCoding(CALIBRATION, (HEIGHT, WIDTH), 38.0)
FOCAL_LENGTH, HORIZON = 721.5377, 172.854


def depth(place: PatchPlace) -> float:
    return FOCAL_LENGTH * CALIBRATION.baseline() / place.disparity


def ahead_of_the_car(env: PatchAttackEnv, calibration: Calibration, radius: float) -> np.ndarray:
    """The action for a patch in the middle of the own lane, 8 m ahead."""
    coding = PatchCoding(calibration, (125, 414), env.patch.radius)
    u, v = calibration.projection(2)[:2, 2]
    disparity = calibration.focal_length() * calibration.baseline() / 8.0
    below = calibration.focal_length() * 1.65 / 8.0
    return coding.encode(PatchPlace(u, v + below - radius, disparity, 0.0, radius))


def test_actions_and_places_convert() -> None:
    low, high = CODING.decode(-np.ones(5)), CODING.decode(np.ones(5))
    assert (low.u, low.v, low.rotation, low.radius) == (0, 0, pytest.approx(-np.pi / 12), 19)
    assert (high.u, high.v, high.rotation, high.radius) == (
        1241,
        374,
        pytest.approx(np.pi / 12),
        38,
    )
    assert (depth(low), depth(high)) == (pytest.approx(20), pytest.approx(8))
    action = np.random.default_rng(0).uniform(-1, 1, 5)
    np.testing.assert_allclose(CODING.encode(CODING.decode(action)), action, atol=1e-12)


def test_every_action_is_a_place_that_can_be() -> None:
    actions = np.random.default_rng(1).uniform(-1, 1, (300, 5))
    for action in [*actions, *np.eye(5), *-np.eye(5), np.ones(5), -np.ones(5)]:
        place = CODING.possible(CODING.decode(action))
        assert place.is_inside(HEIGHT, WIDTH)
        assert 8 - 1e-9 <= depth(place) <= 20 + 1e-9
        lowest = (place.v + place.radius - HORIZON) / FOCAL_LENGTH * depth(place)
        assert lowest <= 1.65 + 1e-9, "nothing stands below the ground"
        assert (np.abs(CODING.encode(place)) <= 1 + 1e-9).all()


def test_places_that_are_drawn_for_random_patches_stay_as_they_are() -> None:
    """The same rules, by which patches are trained."""
    location = [[-3.0, 1.65, 12.0], [2.0, 1.65, 7.0], [6.0, 1.65, 25.0], [1.0, 1.65, -5.0]]
    size = np.tile([1.5, 1.6, 4.0], (4, 1))
    cars = Boxes3D(location, size, np.full(4, -1.5), np.ones(4), np.full(4, "Car"))
    for objects in (None, cars):
        for seed in range(200):
            drawn = random_place(CALIBRATION, (HEIGHT, WIDTH), seed, objects=objects)
            allowed = CODING.possible(drawn, objects)
            for name in ("u", "v", "disparity", "rotation", "radius"):
                assert getattr(allowed, name) == pytest.approx(getattr(drawn, name))


def test_a_patch_is_moved_in_front_of_what_it_covers() -> None:
    wall = Boxes3D([[0, 1.65, 15]], [[9, 0.2, 80]], [0.0], [1.0], ["Misc"])
    beyond = PatchPlace(600, 150, CODING.decode(-np.ones(5)).disparity)
    assert depth(CODING.possible(beyond)) == pytest.approx(20)
    assert depth(CODING.possible(beyond, wall)) == pytest.approx(14.9)


def test_images_without_room_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="no room"):
        PatchCoding(CALIBRATION, (70, 1242), 38.0)


def test_both_images_show_the_patch_and_nothing_else_changes(
    quick: dict[str, Any], bright_cars: ModuleType
) -> None:
    env = PatchAttackEnv(**quick, patch="noise")
    env.reset(seed=0)
    situation = env._situation
    assert situation is not None
    clean = situation.unattacked.frame
    rows, columns = np.mgrid[:125, :414]
    for action in np.random.default_rng(2).uniform(-1, 1, (6, 5)):
        observation, _, _, _, info = env.step(action)
        assert env._last is not None
        attacked = env._last.frame
        budget = Budget(255.0, largest_area(info["radius"]))
        assert not budget.exceeded_by(clean, attacked)
        for camera, u in ((2, info["u"]), (3, info["u"] - info["disparity"])):
            change = np.abs(np.subtract(attacked.image(camera), clean.image(camera), dtype=int))
            away = np.hypot(columns - u, rows - info["v"])
            assert not change[away > info["radius"]].any()
            assert (change[away < info["radius"] - 2].max(axis=1) > 0).mean() > 0.95
            assert attacked.image(camera).dtype == np.uint8
        assert info["area"] == pytest.approx(np.pi * info["radius"] ** 2, rel=0.05)
        coding = PatchCoding(bright_cars.rig().calibration, (125, 414), 38.0)
        place = PatchPlace(*(info[key] for key in ("u", "v", "disparity", "rotation", "radius")))
        np.testing.assert_allclose(observation[SIZE:], coding.encode(place), atol=1e-5)


def test_a_patch_in_the_lane_stops_the_car_and_one_beside_it_does_not(
    quick: dict[str, Any], bright_cars: ModuleType, tmp_path: Path
) -> None:
    """Against a detector that takes what is bright for a car: the smaller patch is cheaper."""
    white = Patch(Patch.grey().pixels * 0 + 255)
    save_patch(tmp_path / "white.safetensors", white)
    env = PatchAttackEnv(**quick, patch=str(tmp_path / "white.safetensors"))
    chosen = {"scenario": "000001", "intention": "straight"}
    rewards, calibration = {}, bright_cars.rig().calibration
    for radius in (19.0, 30.0):
        env.reset(options=chosen)
        _, rewards[radius], terminated, _, info = env.step(
            ahead_of_the_car(env, calibration, radius)
        )
        assert info["radius"] == pytest.approx(radius)
        assert (info["outcome"], info["is_success"], terminated) == ("unplanned", True, True)
        assert info["ghosts"] == 1
        assert rewards[radius] == pytest.approx(1 - 0.02 * (1 + (radius / 38) ** 2))
    assert rewards[19.0] > rewards[30.0]
    env.reset(options=chosen)
    aside = ahead_of_the_car(env, calibration, 19.0)
    aside[0] = 0.9
    _, reward, terminated, _, info = env.step(aside)
    assert (info["outcome"], terminated, info["ghosts"]) == ("safe", False, 1)
    assert reward == pytest.approx(-0.025)


def test_a_live_patch_is_taken_and_a_missing_one_named(quick: dict[str, Any]) -> None:
    patch = Patch.noise(seed=3, radius=20.0)
    env = gym.make(ID, **quick, patch=patch)
    env.reset(seed=0)
    assert env.step(np.ones(5))[-1]["radius"] == 20.0
    with pytest.raises(DataError, match="no-such-file"):
        gym.make(ID, **quick, patch="no-such-file.safetensors")
    with pytest.raises(ConfigurationError, match='Did you mean "joint"'):
        gym.make(ID, **quick, patch="jiont")


def test_by_itself_the_patch_is_the_packages_against_this_detector(
    quick: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def shipped(name: str) -> Path:
        asked.append(name)
        return tmp_path / f"{name}.safetensors"

    monkeypatch.setattr("avsec_gym.attacks.patch_files.shipped_patch", shipped)
    assert torch.equal(PatchAttackEnv(**quick).patch.pixels, Patch.noise().pixels)
    own = save_patch(tmp_path / f"{asked[0]}.safetensors", Patch.noise(seed=3))
    assert torch.equal(PatchAttackEnv(**quick).patch.pixels, own.pixels)
    assert asked == [quick["detector"]] * 2


@pytest.mark.slow
@pytest.mark.parametrize(("attack", "steps"), [("perturbation", 64), ("patch", 320)])
def test_the_study_trains_and_compares(quick: dict[str, Any], attack: str, steps: int) -> None:
    scenes = json.dumps({"source": quick["scenarios"]})
    command = [sys.executable, "-m", "studies.attackers.pixel_attackers", attack]
    command += ["--detector", quick["detector"], "--training", scenes]
    command += ["--testing", quick["scenarios"], "--steps", str(steps), "--held-out", "12"]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    result = json.loads(done.stdout)
    for policy in ("random", "random_search", "cma_es", "sac"):
        assert 0 <= result[policy]["success_rate"] <= 1
        assert 1 <= result[policy]["queries"] <= 10
    assert result["training_queries"] == steps
    if steps >= 160:  # Enough to learn that a patch near and ahead is always seen.
        assert result["sac"]["success_rate"] > result["random"]["success_rate"]
        assert result["sac"]["reward"] > result["random"]["reward"] + 0.3


@pytest.mark.slow
@pytest.mark.parametrize("name", ["PerturbationAttack", "PatchAttack"])
def test_the_example_trains_and_is_judged(quick: dict[str, Any], name: str) -> None:
    scenes = json.dumps({"source": quick["scenarios"]})
    command = [sys.executable, str(ROOT / "examples/train_perturbation_attacker.py")]
    command += ["--id", f"avsec/{name}-v0", "--detector", quick["detector"]]
    command += ["--training", scenes, "--testing", scenes, "--steps", "120", "--held-out", "3"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    won = {name: n for row in done.stdout.splitlines() for name, n in json.loads(row).items()}
    assert list(won) == ["random", "sac"]
    assert all(0 <= count <= 3 for count in won.values())
