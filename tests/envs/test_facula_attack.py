"""`avsec/FaculaAttack-v0`: where the light goes, what it hides, and what raises an alarm."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import cv2
import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401
from avsec_gym.attacks.facula import Facula
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs import validator_report
from avsec_gym.envs.aimed_laser import LASER, RADII, REACH, AimedLaser, full_light
from avsec_gym.envs.facula_attack import FaculaAttackEnv
from avsec_gym.envs.facula_coding import FaculaCoding
from avsec_gym.envs.game_validator import FEWEST, validator_and_played
from avsec_gym.envs.sensor_attack_features import SIZE
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import project
from avsec_gym.perception.detectors.recorded import Oracle
from avsec_gym.pipeline import run_episode
from avsec_gym.scenario.frame_scenes import frame_scenes, frame_scenes_of
from avsec_gym.scenario.scene import Motion
from avsec_gym.sensor_system import KITTI_SYSTEM, SensorSystem
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.evidence.disparity_error import MEASURES, DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.threshold_validator import ThresholdValidator
from avsec_gym.validation.validator import Validation

ROOT = Path(__file__).parents[2]
ID = "avsec/FaculaAttack-v0"
CODING = FaculaCoding((375, 1242), (37.5, 375.0))
HOWS = ("quiet", "loud")
PAIR = {"scenario": "000001", "intention": "straight"}


class Watchman:
    """A validator that says what it is told, and keeps what it was shown."""

    name = "watchman"
    system: SensorSystem = LIDAR_AND_TWO_CAMERAS

    def __init__(self) -> None:
        self.alarm = False
        self.frames: list[SensorFrame] = []

    def validate(self, frame: SensorFrame) -> Validation:
        self.frames.append(frame)
        status = dict.fromkeys(self.system.sensors, SensorStatus.SOUND)
        return Validation(self.alarm, status, DisparityErrors(DisparityMaps(frame, self.system)))


class OracleWithTwoEyes:
    """Knows all objects whose middle is not overexposed in either image."""

    name = "two_eyes"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        boxes = Oracle().detect(frame)
        seen = np.ones(len(boxes), bool)
        for camera in (2, 3):
            middle = boxes.location - [0.0, 0.75, 0.0]
            pixels, _ = project(frame.calibration.projection(camera), middle)
            column, row = np.clip(np.rint(pixels).astype(int), 0, [413, 124]).T
            seen &= frame.image(camera)[row, column].min(axis=1) < 250
        return boxes[seen]


def test_actions_and_faculae_convert() -> None:
    low, high = CODING.decode(-np.ones(4)), CODING.decode(np.ones(4))
    assert (low.camera, low.centre, low.radius) == (2, (0, 0), 37.5)
    assert (high.camera, high.centre, high.radius) == (3, (1241, 374), 375)
    for action in np.random.default_rng(0).uniform(-1, 1, (20, 4)):
        again = CODING.encode(CODING.decode(action))
        np.testing.assert_allclose(again[1:], action[1:], atol=1e-12)
        assert again[0] == (1 if action[0] > 0 else -1)


def test_the_attacker_may_choose_the_strength(quick: dict[str, Any]) -> None:
    coding = FaculaCoding((375, 1242), (37.5, 375.0), (20.0, 220.0))
    assert coding.action_size == 5
    assert [coding.decode(np.full(5, end)).strength for end in (-1, 0, 1)] == [20, 120, 220]
    for action in np.random.default_rng(0).uniform(-1, 1, (20, 5)):
        np.testing.assert_allclose(coding.encode(coding.decode(action))[1:], action[1:], atol=1e-12)
    env = gym.make(ID, **quick, validator=None, strength=(20.0, 220.0))
    seen, info = env.reset(seed=0)
    assert (env.action_space.shape, info["strength"]) == ((5,), 0)
    assert env.observation_space.contains(seen)
    assert len(seen) == len(gym.make(ID, **quick, validator=None).reset(seed=0)[0]) + 1
    seen, *_, info = env.step(np.array([-1.0, 0.0, 0.0, -1.0, -0.5], np.float32))
    assert info["strength"] == pytest.approx(70)
    assert seen[-1] == -0.5
    lit = env.unwrapped._look.frame.image(2)  # type: ignore[attr-defined]
    dark = env.unwrapped.situation.unattacked.frame.image(2)  # type: ignore[attr-defined]
    assert (lit.astype(int) - dark).max() == 70
    with pytest.raises(ConfigurationError, match="the smaller one first"):
        FaculaAttackEnv(**quick, strength=(220.0, 20.0))


def test_clean_scenes_belong_to_thresholds_that_are_measured(watched: dict[str, Any]) -> None:
    for validator in (None, Watchman()):
        with pytest.raises(ConfigurationError, match="`clean` names the scenes"):
            FaculaAttackEnv(**watched, validator=validator).reset(seed=0)


def test_one_image_gets_the_light_and_the_validator_sees_it_too(quick: dict[str, Any]) -> None:
    watchman = Watchman()
    env = gym.make(ID, **quick, validator=watchman)
    env.reset(seed=0)
    clean = watchman.frames[-1]
    for action in np.random.default_rng(1).uniform(-1, 1, (6, 4)):
        *_, info = env.step(action)
        seen = watchman.frames[-1]
        camera = 3 if action[0] > 0 else 2
        assert info["camera"] == camera
        centre = (info["u"], info["v"])
        expected = Facula(camera, info["radius"], centre).attack(clean)
        np.testing.assert_array_equal(seen.image(camera), expected.frame.image(camera))
        np.testing.assert_array_equal(seen.image(5 - camera), clean.image(5 - camera))
        assert info["area"] == expected.pixels[camera].sum() > 0
        np.testing.assert_array_equal(seen.points, clean.points)


def test_an_attack_with_an_alarm_is_no_success(quick: dict[str, Any]) -> None:
    """The same light, on the own lane, before a detector that takes what is bright for a car."""
    watchman = Watchman()
    env = FaculaAttackEnv(**quick, validator=watchman, price=0.1)
    env.reset(options=PAIR)
    action = np.array([-1.0, 0.0, 0.3, -0.6])
    watchman.alarm = True
    seen, reward, terminated, _, info = env.step(action)
    used = (info["radius"] / 375) ** 2
    assert (info["outcome"], info["alarm"], info["is_success"]) == ("unplanned", True, False)
    assert (terminated, seen[SIZE]) == (False, 1)
    assert reward == pytest.approx(-0.1 * (1 + used))
    watchman.alarm = False
    seen, reward, terminated, _, info = env.step(action)
    assert (info["outcome"], info["alarm"], info["is_success"]) == ("unplanned", False, True)
    assert (terminated, seen[SIZE]) == (True, 0)
    assert reward == pytest.approx(1 - 0.1 * (1 + used))


def test_scenes_that_raise_an_alarm_by_themselves_are_never_drawn(quick: dict[str, Any]) -> None:
    watchman = Watchman()
    watchman.alarm = True
    env = FaculaAttackEnv(**quick, validator=watchman)
    with pytest.raises(ConfigurationError, match="without an alarm"):
        env.reset(seed=0)
    env.reset(options=PAIR)
    assert not env.step(np.array([-1.0, 0.0, 0.3, -0.6]))[-1]["is_success"]


@pytest.mark.usefixtures("small_suite")
def test_thresholds_come_from_the_clean_scenes_and_judge_as_the_validator_does() -> None:
    scenes, first = frame_scenes("mixed"), frame_scenes("mixed", count=3)
    frames = [first.frame(scene) for scene in first.scenes.labelled]
    thresholds = {"name": "thresholds", "rate": 0.0}
    validator, played = validator_and_played(thresholds, scenes, first)
    assert isinstance(validator, ThresholdValidator)
    assert [scene.id for scene in played.scenes.scenes] == ["000003", "000004", "000005"]
    with pytest.raises(ConfigurationError, match=r"none is left to be played.*`clean`"):
        validator_and_played(thresholds, first, scenes)
    clean = [validator_report.ValidatorReport.of(validator.validate(frame)) for frame in frames]
    assert not any(report.alarm for report in clean)
    direct = [DisparityErrors(DisparityMaps(f, LIDAR_AND_TWO_CAMERAS))[0, 1, 2] for f in frames]
    for report, expected in zip(clean, direct, strict=True):
        assert report.facts == {"alarm": False} | {m: getattr(expected, m) for m in MEASURES}
    for measure, threshold in zip(MEASURES, validator._chosen[0, 1, 2].shares, strict=True):
        assert threshold == max(getattr(found, measure) for found in direct)
    blinding = Facula(3, 375.0, (600.0 / 3, 60.0), strength=5000.0)
    blinded = validator.validate(blinding.attack(frames[0]).frame)
    assert validator_report.ValidatorReport.of(blinded).alarm
    assert validator_and_played(None, scenes) == (None, scenes)
    assert not any(validator_report.ValidatorReport.of(None).facts.values())
    assert validator_report.MEASURES == MEASURES


def test_contested_situations_are_those_in_which_a_hidden_car_is_in_the_way(
    tmp_path: Path, bright_cars: ModuleType
) -> None:
    """Light on the only car of the left lane: the change of lanes ends in a collision."""
    bright_cars.write_frame(tmp_path, 0, [[60.0, 20.0, 0.0]])
    bright_cars.write_frame(tmp_path, 1, [[13.0, 3.5, 0.0]])
    scenarios = {"source": str(tmp_path), "contested": True}
    env = FaculaAttackEnv(scenarios=scenarios, detector=OracleWithTwoEyes(), price=0.0)
    drawn = {tuple(env.reset(seed=seed)[1][k] for k in PAIR) for seed in range(12)}
    assert drawn == {("000001", "left")}
    situation = env._situation
    assert situation is not None
    frame = situation.unattacked.frame
    middle = situation.scene.boxes.location[0] - [0.0, 0.75, 0.0]
    for camera in (2, 3):
        (u, v), _ = project(frame.calibration.projection(camera), middle)
        hit = env.coding(frame).encode(Facula(camera, 60.0, (u, v)))
        assert env.step(hit)[1:3] == (1.0, True)
        aside = env.coding(frame).encode(Facula(camera, 60.0, (u - 150 * np.sign(u - 207), v)))
        *_, info = env.step(aside)
        assert (info["outcome"], info["found"]) == ("safe", 1)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"radii": [50, 20]}, "radii"),
        ({"radii": [0, 20]}, "radii"),
        ({"radii": [20]}, "radii"),
        ({"strength": 0}, "strength"),
        ({"queries": 0}, "queries"),
    ],
)
def test_wrong_arguments_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigurationError, match=message):
        FaculaAttackEnv(**arguments)


def test_an_unknown_validator_is_refused_at_the_first_reset(
    quick: dict[str, Any], watched: dict[str, Any]
) -> None:
    with pytest.raises(ConfigurationError, match="no validator named 'unheard_of'"):
        FaculaAttackEnv(**quick, validator="unheard_of").reset(seed=0)
    with pytest.raises(ConfigurationError, match="rate"):
        FaculaAttackEnv(**watched, validator={"name": "thresholds", "rate": 2}).reset(seed=0)


def test_by_itself_the_first_half_is_measured_and_the_rest_is_played(
    tmp_path: Path, quick: dict[str, Any], bright_cars: ModuleType
) -> None:
    for number in range(2 * FEWEST):
        bright_cars.write_frame(tmp_path, number, bright_cars.SCENES[number % 3])
    ids = [f"{number:06d}" for number in range(2 * FEWEST)]
    quick["scenarios"] = str(tmp_path)
    env = FaculaAttackEnv(**quick, validator={"name": "thresholds", "criterion": "error"})
    drawn = {env.reset(seed=seed)[1]["scenario"] for seed in range(40)}
    assert len(drawn) > FEWEST / 2
    assert drawn <= set(ids[FEWEST:])
    validator = env.game.pipeline.validator
    assert isinstance(validator, ThresholdValidator)
    assert len(validator._table) == FEWEST
    with pytest.raises(ConfigurationError, match=r"no scene '000003' to play.*of thresholds"):
        env.reset(options={"scenario": "000003"})
    # Where nothing is measured, nothing is kept back.
    env = FaculaAttackEnv(**quick, validator=None)
    assert len(env.game.scenes) == 2 * FEWEST


def test_a_validator_of_sensors_that_the_scenes_lack_is_told(quick: dict[str, Any]) -> None:
    elsewhere = Watchman()
    elsewhere.system = KITTI_SYSTEM
    with pytest.raises(ConfigurationError, match=r"lidar 1 3 2, which.*--sensors lidar 3 2"):
        FaculaAttackEnv(**{**quick, "validator": elsewhere}).reset(seed=0)


def test_too_few_scenes_to_measure_on_are_told(quick: dict[str, Any]) -> None:
    with pytest.raises(ConfigurationError, match=r"has 3 scenes, too few.*`clean`.*avsec validate"):
        FaculaAttackEnv(**quick, validator="thresholds").reset(seed=0)


@pytest.mark.parametrize("clean", [{"count": 1}, {}])
def test_clean_scenes_are_not_played_either(
    quick: dict[str, Any], clean: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of more than `CLEAN`, the first count."""
    monkeypatch.setattr("avsec_gym.envs.game_validator.CLEAN", 1)
    clean = {"source": quick["scenarios"], **clean}
    env = FaculaAttackEnv(**quick, validator="thresholds", clean=clean)
    env.reset(options=PAIR)
    validator = env.game.pipeline.validator
    assert isinstance(validator, ThresholdValidator)
    assert len(validator._table) == 1
    assert [scene.id for scene in env.game.scenes.scenes.scenes] == ["000001", "000002"]
    assert len(frame_scenes_of(quick["scenarios"])) == 3


@pytest.mark.slow
def test_the_study_trains_and_compares(
    tmp_path: Path, watched: dict[str, Any], bright_cars: ModuleType
) -> None:
    situations, seeds = 3, 2
    for name, far in (("training", 13.0), ("testing", 12.0)):
        for number in range(situations):
            bright_cars.write_frame(tmp_path / name, number, [[far + number / 2, 3.5, 0.0]])
    command = [sys.executable, "-m", "studies.attackers.quiet_laser", "--json"]
    command += ["--detector", watched["detector"], "--clean", watched["clean"]]
    command += ["--training", str(tmp_path / "training"), "--held-out", str(situations)]
    command += ["--steps", "48", "--seeds", str(seeds), "--workers", "1", "--testing"]
    refused = subprocess.run([*command, watched["clean"]], capture_output=True, text=True, cwd=ROOT)
    assert "different scenes" in refused.stderr
    command.append(str(tmp_path / "testing"))
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    assert result["situations"] == [f"{number:06d} left" for number in range(situations)]
    assert result["scenes_unsafe_without_attack"] == 0
    assert result["seeds"] == [0, 1]
    assert 0 <= result["thresholds"]["brightness"] < 1
    (tmp_path / "result.json").write_text(done.stdout)
    command = [sys.executable, "-m", "studies.attackers.quiet_laser_page"]
    command += [
        str(tmp_path / "result.json"),
        "--figure",
        str(tmp_path / "a.png"),
        "--markdown",
        str(tmp_path / "a.md"),
    ]
    subprocess.run(command, check=True, cwd=ROOT)
    assert cv2.imread(str(tmp_path / "a.png")).std() > 10
    text = (tmp_path / "a.md").read_text()
    assert "| quiet SAC |" in text
    assert "| by hand, 45 px |" in text
    learners, radii = {"sac", "cma_es", "random_search"}, {}
    for attacker, row in result["attackers"].items():
        once = attacker == "no_attack" or attacker.startswith("by_hand")
        assert [len(letters) for letters in row["outcomes"]] == [situations] * (
            1 if once else seeds
        )
        for name, letters in (("unsafe", "UN"), ("alarm", "nN"), ("unsafe_without_alarm", "U")):
            told = [sum(map(of_seed.count, letters)) / situations for of_seed in row["outcomes"]]
            assert row[name]["by_seed"] == pytest.approx(told, abs=1e-4)
            assert row[name]["rate"] == pytest.approx(np.mean(told), abs=1e-4)
            lower, upper = row[name]["interval"]
            assert 0 <= lower <= row[name]["rate"] <= upper <= 1
        radii[attacker] = row["radius"]
    assert result["attackers"]["no_attack"]["unsafe"]["rate"] == 0
    assert (radii["by_hand_22"], radii["by_hand_180"]) == (22, 180)
    assert 187 <= radii["thesis_facula"] <= 375
    assert {f"{how}_{who}" for how in HOWS for who in learners} <= set(radii)
    assert set(result["quiet_less_loud"]) == learners
    for learner, told in result["quiet_less_loud"].items():
        for name, expected in told.items():
            quiet, loud = (result["attackers"][f"{how}_{learner}"][name] for how in HOWS)
            difference = quiet["rate"] - loud["rate"]
            assert expected["difference"] == pytest.approx(difference, abs=2e-4)
            assert expected["interval"][0] <= expected["difference"] <= expected["interval"][1]


def test_the_laser_is_aimed_at_what_is_in_the_way(
    quick: dict[str, Any], bright_cars: ModuleType, tmp_path: Path
) -> None:
    places = ([[20.0, 0.5, 0.0], [13.0, 3.5, 0.0]], [[13.0, -3.5, 0.0], [30.0, 6.0, 0.0]])
    for number, cars in enumerate(places):
        bright_cars.write_frame(tmp_path, number, cars)
    cars = {**quick, "scenarios": str(tmp_path)}
    made = gym.make(ID, **cars, validator=None, **LASER)
    env = AimedLaser(made)
    for scene, intention, target in (("000000", "left", 1), ("000001", "right", 0)):
        seen, _ = env.reset(options={"scenario": scene, "intention": intention})
        assert env.observation_space.contains(seen)
        situation = made.unwrapped.situation  # type: ignore[attr-defined]
        boxes = situation.scene.boxes
        # A blind eye for each: only without the target the car drives into something.
        safe = [
            run_episode(situation.scene, situation.intention, boxes[[1 - k]], motion=Motion.STATIC)
            for k in range(2)
        ]
        assert [episode.record.safe for episode in safe] == [k != target for k in range(2)]
        middle = boxes.location[[target]] - [[0.0, boxes.dimensions[target, 0] / 2, 0.0]]
        for camera, side in ((2, -1.0), (3, 1.0)):
            beside, above = 0.5, -0.25
            facula = env.facula(np.array([side, beside, above, 0.0, 1.0]))
            place = middle + np.array([REACH[0] * beside, -REACH[1] * above, 0.0])
            frame = situation.unattacked.frame
            expected, _ = project(frame.calibration.projection(camera), place)
            np.testing.assert_allclose(facula.centre, expected[0])
            assert (facula.camera, facula.strength) == (camera, 255)
            assert facula.radius == pytest.approx(np.sqrt(np.prod(RADII)))
    *_, info = env.step(full_light(45))
    assert (info["camera"], info["strength"]) == (2, 255)
    assert info["radius"] == pytest.approx(45)


@pytest.mark.slow
def test_an_attempt_by_hand_is_printed_and_drawn(
    tmp_path: Path, quick: dict[str, Any], bright_cars: ModuleType
) -> None:
    for number in range(2 * FEWEST):
        bright_cars.write_frame(tmp_path, number, [[13.0, 3.5, 0.0]])
    command = [sys.executable, str(ROOT / "examples/aimed_laser.py"), "--scenarios", str(tmp_path)]
    command += ["--detector", quick["detector"], "--attempts", "2"]
    command += ["--out", str(tmp_path / "a.jpg")]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    tried = [line.split(":")[0] for line in told[:-1]]
    assert tried == [f"{FEWEST + number:06d} left" for number in range(len(tried))]
    assert len(tried) == 2 or "collision, no alarm" in told[-2]
    assert told[-1] == str(tmp_path / "a.jpg")
    assert cv2.imread(told[-1]).std() > 10
    refused = subprocess.run([*command, "--radius", "500"], capture_output=True, text=True)
    assert "from 10 to 180" in refused.stderr
