"""`gym.make` takes the parts of another package by their names, in every process."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from avsec_gym.errors import ConfigurationError

DETECTOR = {"name": "stereo_clusters", "disparities": 32}
ATTACKED = {
    "name": "attacked",
    "detector": DETECTOR,
    "attack": {"name": "shifted_image", "pixels": 1},
}
PROGRAM = """
import json, sys
import gymnasium as gym

id, arguments = sys.argv[1], json.loads(sys.argv[2])
env = gym.make(f"avsec_gym:{id}", **arguments)
again = gym.make(gym.envs.registration.EnvSpec.from_json(env.spec.to_json()))
for _ in range(2):
    action = env.action_space.sample()
    played = []
    for made in (env, again):
        observation, info = made.reset(seed=5)
        *_, after = made.step(action)
        played.append((info["scenario"], info["intention"], after["outcome"]))
    assert played[0] == played[1], played
many = gym.make_vec(
    f"avsec_gym:{id}", num_envs=2, vectorization_mode="async",
    vector_kwargs={"context": "spawn"}, **arguments,
)
many.reset(seed=[5, 5])
*_, infos = many.step(gym.vector.utils.batch_space(env.action_space, 2).sample())
assert set(infos["scenario"]) == {played[0][0]}, infos
many.close()
print(json.dumps({"played": played[0], "info": {name: str(v) for name, v in after.items()}}))
"""


@pytest.mark.parametrize(
    ("id", "more"),
    [
        (
            "avsec/FaculaAttack-v0",
            {"detector": DETECTOR, "planner": "lane_change", "validator": "stereo_and_scan"},
        ),
        pytest.param(
            "avsec/LidarSpoofing-v0",
            {"validator": {"name": "stereo_and_scan", "most": 0.5}},
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "avsec/PerturbationAttack-v0",
            {"detector": ATTACKED, "planner": "lane_change"},
            marks=pytest.mark.slow,
        ),
        (
            "avsec/DetectorBenchmark-v0",
            {"planner": {"name": "lane_change", "hardest": 2.0}, "attack": "shifted_image"},
        ),
    ],
)
def test_they_play_in_a_process_and_in_the_workers_of_a_vector_environment(
    installed: None, data: Path, id: str, more: dict[str, object]
) -> None:
    arguments = json.dumps({"scenarios": str(data), **more})
    done = subprocess.run(
        [sys.executable, "-W", "error::UserWarning", "-c", PROGRAM, id, arguments],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    scenario, _, outcome = json.loads(done.stdout)["played"]
    assert scenario in {"000001", "000002", "000003"}
    assert outcome in {"safe", "collision", "unplanned"}


def test_the_attacked_images_are_what_a_detector_sees(installed: None, data: Path) -> None:
    import gymnasium as gym

    from avsec_gym.envs.detector_policy import DetectorPolicy

    depths = {}
    for attack in (None, {"name": "shifted_image", "pixels": 5}):
        env = gym.make("avsec/DetectorBenchmark-v0", scenarios=str(data), attack=attack)
        observation, _ = env.reset(seed=3)
        action, _ = DetectorPolicy(DETECTOR, env).predict(observation)
        boxes = env.unwrapped.coding.decode(action)
        *_, after = env.step(action)
        depths[attack is None] = min(boxes.location[:, 2])
        if attack is None:
            assert (after["found"], after["reported"]) == (1, 1)
    assert depths[True] == pytest.approx(10.0 + 2.0, abs=0.5)
    assert depths[False] == pytest.approx(100 / 15 + 2.0, abs=0.5)


@pytest.mark.parametrize(
    ("id", "slip", "meant"),
    [
        ("avsec/FaculaAttack-v0", {"detector": "stereo_cluster"}, "stereo_clusters"),
        ("avsec/FaculaAttack-v0", {"validator": "stereo_and_scam"}, "stereo_and_scan"),
        ("avsec/DetectorBenchmark-v0", {"planner": "lane_chagne"}, "lane_change"),
        ("avsec/DetectorBenchmark-v0", {"attack": "shifted_images"}, "shifted_image"),
        (
            "avsec/DetectorBenchmark-v0",
            {"attack": {"name": "shifted_image", "pixel": 3}},
            "pixels",
        ),
    ],
)
def test_a_slip_in_a_name_is_told(
    installed: None, data: Path, id: str, slip: dict[str, object], meant: str
) -> None:
    import gymnasium as gym

    with pytest.raises(ConfigurationError, match=f'Did you mean "{meant}"'):
        gym.make(id, scenarios=str(data), **slip)
