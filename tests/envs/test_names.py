"""Wrong names are refused by `gym.make`, which asks what was meant; nothing is made before.

The arguments are read from the signatures, so that a new environment is covered by itself.
"""

from __future__ import annotations

import inspect
import json
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import gymnasium as gym
import pytest
from gymnasium.envs.registration import load_env_creator

from avsec_gym.errors import AvsecError, ConfigurationError
from avsec_gym.registration import CATALOGUE
from avsec_gym.registry import Kind
from avsec_gym.scenario.scene import Motion
from avsec_gym.sensor_system import KITTI_SYSTEM
from avsec_gym.validation.shipped import shipped_file
from avsec_gym.world.export import default_suites

ENTRY_POINTS = [
    point
    for entry in CATALOGUE
    for point in (entry.entry_point, entry.vector_entry_point)
    if point is not None
]
PARTS = {str(kind) for kind in Kind}


def parameters(point: str) -> dict[str, inspect.Parameter]:
    return dict(inspect.signature(load_env_creator(point)).parameters)


def takes_a_name(parameter: inspect.Parameter) -> bool:
    """By its default, or by what it may be (annotations are texts)."""
    alternatives = {word.strip() for word in str(parameter.annotation).split("|")}
    return isinstance(parameter.default, str) or bool({"str", "Any"} & alternatives)


def takes_a_dictionary(parameter: inspect.Parameter) -> bool:
    return parameter.annotation == "Any"


NAMES = [
    pytest.param(point, name, id=f"{point.rpartition(':')[2]}-{name}")
    for point in ENTRY_POINTS
    for name, parameter in parameters(point).items()
    if takes_a_name(parameter)
]


@pytest.fixture(autouse=True)
def _nothing_is_rendered(monkeypatch: pytest.MonkeyPatch) -> None:
    def cached(*_: Any) -> None:
        raise AssertionError("a suite is made before the names are looked at")

    monkeypatch.setattr(default_suites, "cached", cached)


def wrong(point: str, name: str) -> Iterator[tuple[Any, str]]:
    """Values with a slip, and what was meant: empty where that cannot be known."""
    parameter = parameters(point)[name]
    meant = str(parameter.default) if isinstance(parameter.default, str) else ""
    if name == "render_mode" and "Vector" not in point:
        meant = "rgb_array"
    yield (f"{meant[:-1]}{meant[-1]}x" if meant else "no-such-name", meant)
    if takes_a_dictionary(parameter):
        key = "source" if name in ("scenarios", "clean") and "ghost" not in point else "name"
        yield ({key: f"{meant}x" if meant else "no-such-name"}, meant)
        yield ({f"{key}x": meant}, "")
        if name in PARTS:
            yield (5, "")
            yield ({"name": None}, "")


@pytest.mark.parametrize(("point", "name"), NAMES)
def test_a_wrong_name_is_refused_and_asked_about(point: str, name: str) -> None:
    for value, meant in wrong(point, name):
        expected = ConfigurationError if meant or name in PARTS else AvsecError
        with pytest.raises(expected) as raised:
            load_env_creator(point)(**{name: value})
        if meant:
            assert f'Did you mean "{meant}"?' in str(raised.value)


def test_names_are_looked_for_where_they_are() -> None:
    """The signatures tell of all arguments that the catalogue's pages call names."""
    found = {parameter.id for parameter in NAMES}
    for expected in (
        "GhostObjectEnv-scenarios",
        "GhostObjectEnv-ghost",
        "GhostObjectVectorEnv-planner",
        "DetectorBenchmarkEnv-motion",
        "PerturbationAttackEnv-detector",
        "PatchAttackEnv-patch",
        "FaculaAttackEnv-validator",
        "LidarSpoofingEnv-clean",
        "SensorIdentificationEnv-depth",
        "SensorIdentificationEnv-render_mode",
    ):
        assert expected in found
    assert not any(id.endswith(("-queries", "-price", "-image")) for id in found)


@pytest.mark.parametrize("entry", CATALOGUE, ids=lambda entry: entry.id)
def test_gym_make_tells_it_as_it_is(entry: Any) -> None:
    """Gymnasium's own errors are no errors of ours: it lets these pass."""
    with pytest.raises(AvsecError):
        gym.make(entry.id, scenarios="no-such-scenarios")
    with pytest.raises(AvsecError):
        gym.make_vec(entry.id, num_envs=2, scenarios="no-such-scenarios")


# Those whose car is attacked, and how it comes to read its sensors.
ATTACKED: dict[str, list[dict[str, Any]]] = {
    "avsec/DetectorBenchmark-v0": [{}, {"observation": "thumbnails"}, {"observation": "features"}],
    "avsec/SensorIdentification-v0": [{}, {"scenarios": "mixed"}],
    "avsec/ClosedLoop-v0": [
        {"scenarios": "drives", "perception": level} for level in ("sensors", "lidar", "stereo")
    ],
}


def test_every_attack_on_sensors_is_looked_at() -> None:
    takes = {
        entry.id
        for entry in CATALOGUE
        if {"attack", "detector"} <= set(parameters(entry.entry_point))
    }
    assert takes == set(ATTACKED)


@pytest.mark.parametrize(
    ("id", "arguments"),
    [pytest.param(id, each, id=f"{id}-{each}") for id in ATTACKED for each in ATTACKED[id]],
)
def test_an_attack_on_a_sensor_that_the_car_lacks_is_refused(
    id: str, arguments: dict[str, Any]
) -> None:
    """It was accepted, and failed at the first reset, once the suite had been rendered."""
    with pytest.raises(ConfigurationError, match=r"is one on camera 7, but .* have "):
        gym.make(id, attack={"name": "facula", "camera": 7}, **arguments)


@pytest.mark.parametrize(
    ("level", "attack", "lacks"),
    [("lidar", "facula", "camera 2"), ("stereo", "lidar_spoofing", "the LiDAR")],
)
def test_an_attack_on_what_a_level_does_not_read_is_refused(
    level: str, attack: str, lacks: str
) -> None:
    drive = {"scenarios": "drives", "perception": level}
    with pytest.raises(ConfigurationError, match=f"is one on {lacks}, but"):
        gym.make("avsec/ClosedLoop-v0", attack=attack, **drive)
    # A validator compares all sensors, so that all are read.
    table = {"name": "thresholds", "thresholds": shipped_file("thresholds", KITTI_SYSTEM)}
    gym.make("avsec/ClosedLoop-v0", attack=attack, validator=table, **drive)


@pytest.mark.parametrize(
    ("level", "kind", "lacks"),
    [("lidar", "facula", "camera"), ("stereo", "spoofed_scan", "the LiDAR")],
)
def test_an_agent_that_attacks_what_a_level_does_not_read_is_refused(
    level: str, kind: str, lacks: str
) -> None:
    with pytest.raises(ConfigurationError, match=f"is one on {lacks}.*, but drives"):
        gym.make("avsec/ClosedLoopAttack-v0", scenarios="drives", perception=level, kind=kind)


@pytest.mark.parametrize("level", ["sensors", "lidar", "stereo"])
def test_sensors_are_read_only_where_scenes_have_some(level: str) -> None:
    with pytest.raises(ConfigurationError, match="sensor data, which these scenes do not have"):
        gym.make("avsec/ClosedLoop-v0", scenarios="layouts", perception=level)
    if level == "sensors":
        with pytest.raises(ConfigurationError, match="sensor data, which these scenes do not have"):
            gym.make(
                "avsec/ClosedLoopAttack-v0", scenarios="layouts", perception=level, kind="facula"
            )


MOTIONS = [point for point in ENTRY_POINTS if "motion" in parameters(point)]


@pytest.mark.parametrize("point", MOTIONS)
@pytest.mark.parametrize("motion", list(Motion))
def test_every_motion_is_played_or_refused_at_once(
    point: str, motion: Motion, watched: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.undo()
    offered = {"scenarios": watched["scenarios"], "detector": watched["detector"]}
    if "ghost" in point:
        offered = {"scenarios": {"name": "layouts", "count": 12}}
    given = {name: value for name, value in offered.items() if name in parameters(point)}
    if "validator" in parameters(point):
        given["validator"] = None
    if "perception" in parameters(point):  # Cars that know the truth take no detector.
        del given["detector"]
    try:
        env = load_env_creator(point)(motion=str(motion), **given)
    except ConfigurationError as error:
        said = str(error)
    else:
        said = ""
    if said:
        assert motion == Motion.CLASSIFIER
        assert 'use "static" or "truth"' in said
        return
    env.reset(seed=0)
    env.action_space.seed(0)
    for _ in range(3):
        env.step(env.action_space.sample())
    env.close()


def test_splits_are_names_too() -> None:
    for frames in ({"source": "mixed", "split": "vall"}, {"source": ["street"], "split": "trian"}):
        with pytest.raises(ConfigurationError, match=r'Did you mean "(val|train)"'):
            gym.make("avsec/PatchAttack-v0", scenarios=frames)


def test_nothing_heavy_is_loaded_to_look_at_names() -> None:
    """Names of networks are known without the networks."""
    program = (
        "import json, sys, gymnasium as gym; wrong = json.loads(sys.argv[1])\n"
        "for id in ('Perturbation', 'Patch', 'Facula'):\n"
        "    try: gym.make(f'avsec_gym:avsec/{id}Attack-v0', **wrong)\n"
        "    except Exception as error: print(type(error).__name__)\n"
        "    gym.make(f'avsec_gym:avsec/{id}Attack-v0')\n"
        "print([m for m in ('torch', 'cv2', 'matplotlib') if m in sys.modules])"
    )
    command = [sys.executable, "-c", program, json.dumps({"detector": "dsgm"})]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd="/")
    assert done.stdout.split("\n")[:-1] == ["ConfigurationError"] * 3 + ["[]"]
