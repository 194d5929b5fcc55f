"""Environments with every part in them, made by one `gym.make` and played; and on real frames."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401
from avsec_gym.closed_loop.loop_scenes import LoopScenes
from avsec_gym.closed_loop.procedural_drives import procedural_drive
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.envs.stereo_profile import FARTHEST, SECTORS, stereo_profile
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.pipeline import Pipeline
from avsec_gym.rig import kitti_rig, resized_rig
from avsec_gym.validation.compromised_sensors import Untrusted
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitting import CleanFrames, fit_threshold_table
from avsec_gym.validation.recordings import RecordedFrame
from avsec_gym.validation.response import Response
from tests.envs.test_facula_attack import Watchman

PARTS = {
    "detector": "dsgn",
    "classifier": "small",
    "selector": "small",
    "planner": {"name": "gbfs", "node_limit": 5000},
    "validator": {"name": "thresholds", "criterion": "error"},
    "response": "drop",
    "motion": "classifier",
    "score_threshold": 0.2,
}
"""All but the scenes, and the attack where the agent plays it."""
DEFENDED = ("PerturbationAttack", "PatchAttack", "FaculaAttack", "LidarSpoofing")
BLINDING = {"name": "facula", "camera": 2, "radius": 90.0, "centre": (207.0, 60.0)}


@pytest.fixture
def scenes(watched: dict[str, Any]) -> dict[str, Any]:
    """Small frames to play on, and others to measure thresholds on."""
    return {"scenarios": watched["scenarios"], "clean": watched["clean"]}


def played(id: str, **given: Any) -> Iterator[dict[str, Any]]:
    """What `info` reports of an episode with random actions."""
    env = gym.make(f"avsec/{id}-v0", **given)
    env.action_space.seed(0)
    seen, info = env.reset(seed=0)
    assert env.observation_space.contains(seen)
    yield info
    ended = False
    while not ended:
        seen, _, terminated, truncated, info = env.step(env.action_space.sample())
        assert env.observation_space.contains(seen)
        ended = terminated or truncated
        yield info
    env.close()


def parts_in(pipeline: Pipeline) -> dict[str, str]:
    """The classes of what a pipeline is made of."""
    names = ("detector", "attack", "classifier", "selector", "planner", "validator")
    return {name: type(getattr(pipeline, name)).__name__ for name in names}


def test_a_detector_is_judged_with_every_part_in_the_car(scenes: dict[str, Any]) -> None:
    """Whether one makes it by names, dictionaries, or both."""
    env = gym.make("avsec/DetectorBenchmark-v0", **scenes, **PARTS, attack="thesis_pgd")
    env.reset(seed=0)
    *_, info = env.step(env.action_space.sample())
    assert info["outcome"] in ("safe", "collision", "unplanned")
    pipeline = env.unwrapped.pipeline  # type: ignore[attr-defined]
    assert parts_in(pipeline) == {
        "detector": "Reported",
        "attack": "Perturbation",
        "classifier": "MovingObjectClassifier",
        "selector": "DrivingConstraintSelector",
        "planner": "MotionPrimitivePlanner",
        "validator": "ThresholdValidator",
    }
    assert (pipeline.response, pipeline.score_threshold) == (Response.DROP, 0.2)
    assert pipeline.victim.name == "dsgn"


@pytest.mark.parametrize("id", DEFENDED)
def test_attackers_play_against_a_car_with_every_part(id: str, scenes: dict[str, Any]) -> None:
    env = gym.make(f"avsec/{id}-v0", **scenes, **(PARTS | {"detector": "oracle"}))
    env.action_space.seed(0)
    env.reset(seed=0, options={"scenario": "000001"})
    *_, info = env.step(env.action_space.sample())
    assert type(info["alarm"]) is bool
    assert parts_in(env.unwrapped.game.pipeline) == {  # type: ignore[attr-defined]
        "detector": "Oracle",
        "attack": "NoneType",
        "classifier": "MovingObjectClassifier",
        "selector": "DrivingConstraintSelector",
        "planner": "MotionPrimitivePlanner",
        "validator": "ThresholdValidator",
    }


def test_a_validator_is_judged_by_the_drive_too(scenes: dict[str, Any]) -> None:
    """A false alarm stops the car, and silence lets it drive."""
    parts = {name: PARTS[name] for name in PARTS if name != "validator"} | {"detector": "oracle"}
    env = gym.make(
        "avsec/SensorIdentification-v0",
        scenarios=scenes["scenarios"],
        **(parts | {"response": "stop", "unattacked": 1.0}),
    )
    options = {"scenario": "000001", "intention": "straight"}
    outcomes = []
    for answer in ([0, 0, 0], [1, 0, 0]):
        env.reset(seed=0, options=options)
        *_, info = env.step(np.array(answer, np.int8))
        outcomes.append(info["outcome"])
    assert outcomes == ["safe", "unplanned"]
    assert np.isnan(info["smallest_distance"])


@pytest.fixture(scope="module")
def small_drive() -> tuple[TrafficScene, SensorFrame]:
    """A procedural drive whose frames are rendered small, and its first frame."""
    scene = procedural_drive(0, 3, rig=resized_rig(kitti_rig(), 414))
    start = scene.start
    assert scene.sensors is not None
    return scene, scene.sensors(0.0, (start.x, start.y, start.heading), {})


@pytest.fixture
def drive(small_drive: tuple[TrafficScene, SensorFrame], tmp_path: Path) -> dict[str, Any]:
    """What a car with every part is made of, half a second long; its thresholds are in a file."""
    scene, frame = small_drive
    clean = [RecordedFrame("start", lambda: frame)]
    table = fit_threshold_table(CleanFrames(clean, LIDAR_AND_TWO_CAMERAS, PairDepth(), {}))
    # One frame shows little of what others are like: thresholds far beyond it.
    table = replace(table, shares=0.1 + 0.9 * table.shares)
    table.write(tmp_path / "thresholds.json")
    return {
        "scenarios": LoopScenes((scene.id,), lambda id: scene),
        "perception": "sensors",
        "duration": 0.5,
        **PARTS,
        "validator": {"name": "thresholds", "thresholds": str(tmp_path / "thresholds.json")},
    }


LASER = {"name": "facula", "camera": 3, "radius": 200.0, "centre": (207.0, 60.0)}
IN_THE_LOOP = {
    "detector": "DsgnDetector",
    "attack": "Facula",
    "classifier": "MovingObjectClassifier",
    "selector": "DrivingConstraintSelector",
    "planner": "MotionPrimitivePlanner",
    "validator": "ThresholdValidator",
}


def test_a_car_drives_on_with_every_part(drive: dict[str, Any]) -> None:
    """The laser is detected and reported, and the car drives on by what all parts make of it."""
    env = gym.make("avsec/ClosedLoop-v0", attack=LASER, **(drive | {"response": None}))
    played: Any = env.unwrapped
    driver = PlannerDriver(env)
    observation, _ = env.reset(seed=0)
    ended = False
    while not ended:
        observation, _, terminated, truncated, info = env.step(driver.predict(observation)[0])
        ended = terminated or truncated
    assert info["outcome"] in ("goal", "time", "stopped", "collision")
    assert parts_in(played.perception.pipeline) == IN_THE_LOOP
    seen = played.perception.perceive(played.surroundings())
    assert seen.validation.alarm
    assert {"validator", "detector", "classifier", "selector"} <= set(seen.seconds)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("part", "without"),
    [
        ("attack", {"attack": None}),
        ("validator", {"validator": None}),
        ("classifier", {"classifier": None, "motion": "static"}),
        ("selector", {"selector": None}),
    ],
)
def test_one_line_takes_a_part_out_of_the_car(
    part: str,
    without: dict[str, Any],
    drive: dict[str, Any],
    small_drive: tuple[TrafficScene, SensorFrame],
) -> None:
    """All others stay, and the car is driven; its sensors deliver the same frame all the time."""
    scene, frame = small_drive
    scene = replace(scene, sensors=lambda *_: frame)
    whole = {
        **drive,
        "attack": LASER,
        "response": None,
        "scenarios": LoopScenes((scene.id,), lambda id: scene),
    }
    env = gym.make("avsec/ClosedLoop-v0", **(whole | without))
    played: Any = env.unwrapped
    observation, _ = env.reset(seed=0)
    *_, info = env.step(PlannerDriver(env).predict(observation)[0])
    assert info["outcome"] == "driving"
    assert parts_in(played.perception.pipeline) == IN_THE_LOOP | {part: "NoneType"}
    seen = played.perception.perceive(played.surroundings())
    judged = seen.validation is not None and seen.validation.alarm
    assert judged == (part not in ("attack", "validator"))
    assert (seen.believed.moving is None) == (part == "classifier")
    assert (seen.road_type is None) == (part == "selector")


def test_one_line_takes_the_sensors_out_of_the_car() -> None:
    """It then knows the truth, and nothing is rendered; the planner drives on."""
    env = gym.make("avsec/ClosedLoop-v0", scenarios={"source": "drives", "count": 1})
    observation, _ = env.reset(seed=0)
    *_, info = env.step(PlannerDriver(env).predict(observation)[0])
    played: Any = env.unwrapped
    assert info["outcome"] == "driving"
    assert len(played.belief.poses) == len(played.surroundings().boxes)


EVERY_FRAME = {"name": "planner", "replanning": 0.1}
"""A driver that looks at, and plans anew on, every frame."""


def played_in_the_loop(env: Any, action: list[float]) -> dict[str, Any]:
    """The last info of a drive straight on under one action."""
    ids = env.unwrapped.drive.scenes.ids
    env.reset(seed=0, options={"scenario": ids[0], "intention": "straight"})
    ended = False
    while not ended:
        *_, terminated, truncated, info = env.step(np.array(action, np.float32))
        ended = terminated or truncated
    return dict(info)


@pytest.mark.slow
def test_a_laser_plays_against_a_driving_car_with_every_part(drive: dict[str, Any]) -> None:
    """Its light reaches the cameras: the validator detects it, and nothing without it."""
    env = gym.make("avsec/ClosedLoopAttack-v0", kind="facula", driver=EVERY_FRAME, **drive)
    pipeline = env.unwrapped.perception.pipeline  # type: ignore[attr-defined]
    assert parts_in(pipeline) == IN_THE_LOOP | {"attack": "NoneType"}
    dark = played_in_the_loop(env, [-1.0, 1.0, 0.0, 0.0, 1.0])
    lit = played_in_the_loop(env, [1.0, 1.0, 0.0, 0.0, 1.0])
    assert (dark["frames"], dark["alarms"]) == (0, 0)
    assert lit["frames"] - 1 == lit["alarms"] > 0  # The frame at the goal is not read.
    assert lit["camera"] == 3


@pytest.mark.slow
def test_a_spoofer_plays_against_a_car_that_drives_by_its_scan(drive: dict[str, Any]) -> None:
    """What stands in the scan at the place, 10 m ahead at first, is there for the car."""
    parts = drive | {"detector": "scan_obstacles", "validator": None}
    env = gym.make("avsec/ClosedLoopAttack-v0", kind="spoofed_scan", driver=EVERY_FRAME, **parts)
    found = []
    for up in (-1.0, 1.0):
        played_in_the_loop(env, [up, -0.7, 0.0, 1.0, 1.0])
        drive_: Any = env.unwrapped.drive  # type: ignore[attr-defined]
        start, belief = drive_.scene.start, drive_.belief
        ahead = start.x + 10.25 * np.cos(start.heading), start.y + 10.25 * np.sin(start.heading)
        found.append(np.hypot(*(belief.poses[:, :2] - ahead).T).min(initial=np.inf) < 2.0)
    assert found == [False, True]


def attacked_pixels(scenes: dict[str, Any], **given: Any) -> np.ndarray:
    seen, _ = gym.make("avsec/DetectorBenchmark-v0", **scenes, **given).reset(seed=1)
    return np.asarray(seen["left"]).astype(int)


def test_an_attack_takes_the_judged_detectors_gradients_or_those_of_another(
    scenes: dict[str, Any],
) -> None:
    scenes = {"scenarios": scenes["scenarios"]}
    attack = {"name": "thesis_pgd", "alpha": 2.0, "steps": 1}
    clean = attacked_pixels(scenes)
    known = attacked_pixels(scenes, attack=attack, detector="dsgn")
    transferred = {"name": "transferred", "attack": attack, "of": "dsgn"}
    np.testing.assert_array_equal(attacked_pixels(scenes, attack=transferred), known)
    other = attacked_pixels(scenes, attack=transferred | {"of": "stereo_rcnn"})
    for changed in (known, other):
        assert np.abs(changed - clean).max() == 2
    assert (known != other).mean() > 0.1
    with pytest.raises(ConfigurationError, match="needs a detector that it knows"):
        gym.make("avsec/DetectorBenchmark-v0", **scenes, attack=attack)


@pytest.mark.parametrize("response", ["stop", None])
def test_an_alarm_takes_the_attackers_success(quick: dict[str, Any], response: str | None) -> None:
    """The same light on the lane, which no plan passes: with an alarm, and without."""
    watchman, light = Watchman(), np.array([-1.0, 0.0, 0.3, -0.6])
    env = gym.make("avsec/FaculaAttack-v0", **quick, validator=watchman, response=response)
    where = {"scenario": "000001", "intention": "straight"}
    for alarm in (True, False):
        watchman.alarm = False
        env.reset(options=where)
        watchman.alarm = alarm
        *_, info = env.step(light)
        assert (info["outcome"], info["alarm"]) == ("unplanned", alarm)
        assert info["is_success"] != alarm


def test_a_car_that_drops_its_sensors_at_an_alarm_may_still_be_harmed(
    quick: dict[str, Any],
) -> None:
    """The watchman calls every sensor sound: the car keeps all, and finds no way."""
    watchman = Watchman()
    env = gym.make("avsec/FaculaAttack-v0", **quick, validator=watchman, response="drop")
    env.reset(options={"scenario": "000001", "intention": "straight"})
    watchman.alarm = True
    *_, info = env.step(np.array([-1.0, 0.0, 0.3, -0.6]))
    assert (info["alarm"], info["is_success"]) == (True, True)


def test_a_detector_gets_what_the_validator_trusts(
    quick: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the car stops, whatever is reported, where nothing can be trusted."""
    watchman = Watchman()
    given = {"scenarios": quick["scenarios"], "validator": watchman}
    env = gym.make("avsec/DetectorBenchmark-v0", **given)
    where = {"scenario": "000001", "intention": "straight"}
    nothing = np.full(env.action_space.shape, -1.0, np.float32)  # type: ignore[arg-type]
    for alarm, outcome in ((False, "safe"), (True, "unplanned")):
        watchman.alarm = alarm
        env.reset(options=where)
        *_, info = env.step(nothing)
        assert (info["alarm"], info["outcome"]) == (alarm, outcome)

    def refuse(*_: Any) -> None:
        raise Untrusted("a camera is gone")

    monkeypatch.setattr("avsec_gym.pipeline.trusted_frame", refuse)
    seen, _ = env.reset(options=where)
    assert env.observation_space.contains(seen)
    assert env.step(nothing)[-1]["outcome"] == "unplanned"


def test_the_profile_shows_where_things_stand(bright_cars: ModuleType) -> None:
    """A board before a wall, both of noise, as two cameras see them."""
    calibration = bright_cars.rig().calibration
    focal, scale = calibration.focal_length(2), calibration.focal_length(2) * calibration.baseline()
    near, far = 10, 3  # Pixels.
    wall = np.random.default_rng(0).integers(0, 256, (125, 440, 3)).astype(np.uint8)
    board = np.random.default_rng(1).integers(0, 256, (125, 40, 3)).astype(np.uint8)
    left, right = wall[:, :414].copy(), wall[:, far : 414 + far].copy()
    left[:, 300:340], right[:, 300 - near : 340 - near] = board, board
    frame = SensorFrame("000000", calibration, {2: left, 3: right})
    profile = stereo_profile(frame)
    assert profile.shape == (2 * SECTORS,)
    assert (profile.min() >= 0, profile.max() <= 1) == (True, True)
    distance, area = FARTHEST * profile[:SECTORS], 4.0 * profile[SECTORS:]

    def sector(column: float) -> int:
        bearing = np.arctan2(column - calibration.projection(2)[0, 2], focal)
        return int((bearing + 0.7) / 1.4 * SECTORS)

    assert distance[sector(320)] == pytest.approx(scale / near, abs=1)
    assert distance[sector(200)] == pytest.approx(scale / far, abs=1.5)
    assert area[sector(320)] > 0.1
    blank = SensorFrame("000001", calibration, dict.fromkeys((2, 3), np.zeros_like(left)))
    np.testing.assert_array_equal(stereo_profile(blank)[:SECTORS], 1.0)
    np.testing.assert_array_equal(stereo_profile(blank)[SECTORS:], 0.0)


@pytest.mark.parametrize("id", ["DetectorBenchmark", *DEFENDED])
def test_agents_without_eyes_get_a_flat_vector(id: str, quick: dict[str, Any]) -> None:
    more = {} if id == "DetectorBenchmark" else {"detector": "oracle"}
    env = gym.make(f"avsec/{id}-v0", scenarios=quick["scenarios"], observation="features", **more)
    seen, _ = env.reset(seed=0)
    assert isinstance(env.observation_space, gym.spaces.Box)
    assert len(seen.shape) == 1
    assert np.isfinite(seen).all()


@pytest.mark.parametrize("algorithm", ["PPO", "SAC"])
def test_images_are_so_small_that_usual_networks_stay_small(
    algorithm: str, quick: dict[str, Any]
) -> None:
    import stable_baselines3

    env = gym.make("avsec/PerturbationAttack-v0", **quick, observation="images")
    assert env.observation_space.shape == (48, 160, 3)
    given = {"buffer_size": 10} if algorithm == "SAC" else {}
    model = getattr(stable_baselines3, algorithm)("CnnPolicy", env, **given)
    assert sum(weights.numel() for weights in model.policy.parameters()) < 5e6


@pytest.mark.slow
@pytest.mark.usefixtures("small_suite")
def test_the_lines_of_the_page_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its first lines, and those on contested scenes."""
    monkeypatch.setattr("avsec_gym.envs.game_validator.FEWEST", 3)
    page = (Path(__file__).parents[2] / "docs/environments.md").read_text()
    blocks = [block.partition("```")[0] for block in page.split("```python")[1:]]
    first, contested = blocks[0], next(block for block in blocks if "mixed_contested" in block)
    made: dict[str, Any] = {}
    exec(first + contested, made)
    judged = made["judged"]
    judged.reset(seed=0, options={"scenario": "000005"})
    assert made["validator"].reset(seed=0)[1]["outcome"] == "reset"
    assert made["objects"].reset(seed=0)[1]["outcome"] == "reset"


@pytest.mark.parametrize(
    "id", ["DetectorBenchmark", *DEFENDED, "SensorIdentification"], ids=lambda id: id
)
@pytest.mark.parametrize("looks", [False, True], ids=["oracle", "network"])
def test_every_environment_plays_on_real_frames(id: str, looks: bool, shared: Path) -> None:
    """As the thesis labelled them, the real objects standing and moving as its flags state."""
    real = {"source": str(shared / "kitti/object"), "scenarios": str(shared / "safety_scenarios")}
    if id == "LidarSpoofing":
        detector = "pixor" if looks else "scan_obstacles"
    else:
        detector = "stereo_rcnn" if looks else "oracle"
    infos = list(played(id, scenarios=real, detector=detector))
    assert {info["scenario"] for info in infos} == {"000107"}
    for info in infos[1:]:
        assert {"success", "collision", "safe", "is_success"} <= set(info)
        assert info["success"] == (info["outcome"] in ("safe", "collision"))
    if id in DEFENDED:
        assert infos[0]["objects"] == 8


@pytest.mark.parametrize("version", [0, 1])
@pytest.mark.parametrize("folder", ["safety_scenarios", "kitti/object"])
def test_the_game_without_images_plays_in_real_scenes(
    version: int, folder: str, shared: Path
) -> None:
    scenes = {"name": str(shared / folder), "count": 30}
    env = gym.make(f"avsec/GhostObject-v{version}", scenarios=scenes)
    env.action_space.seed(0)
    for seed in range(5):
        env.reset(seed=seed)
        *_, info = env.step(env.action_space.sample())
        assert info["success"] == np.isfinite(info["path_length"])


@pytest.mark.parametrize("id", ["ClosedLoop", "ClosedLoopAttack"])
@pytest.mark.parametrize(
    ("folder", "given"), [("kitti/object", {}), ("safety_scenarios", {"count": 2})]
)
def test_a_car_drives_on_in_real_scenes(
    folder: str, given: dict[str, Any], id: str, shared: Path
) -> None:
    """In a KITTI folder with images, and in the thesis' labelled scenarios; a planner drives."""
    real = {"source": str(shared / folder), **given}
    env = gym.make(f"avsec/{id}-v0", scenarios=real)
    env.action_space.seed(0)
    driver = PlannerDriver(env) if id == "ClosedLoop" else None
    known = (env.unwrapped if driver else env.unwrapped.drive).scenes.ids  # type: ignore[attr-defined]
    for scene in known:
        seen, info = env.reset(seed=0, options={"scenario": scene})
        ended = False
        while not ended:
            assert env.observation_space.contains(seen)
            action = driver.predict(seen)[0] if driver else env.action_space.sample()
            seen, _, terminated, truncated, info = env.step(action)
            ended = terminated or truncated
        assert info["scenario"] == scene
        assert info["success"] == (info["outcome"] in ("goal", "collision"))
        assert info["collision"] == (info["outcome"] == "collision")
        assert info["safe"] == (info["outcome"] == "goal")
