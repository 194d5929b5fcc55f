"""The parts of environments: refused at once where they cannot be, made as they are named."""

from __future__ import annotations

import os
import subprocess
import sys
from types import SimpleNamespace
from typing import Any

import pytest

from avsec_gym.envs.parts import Parts
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner
from avsec_gym.registry import Kind
from avsec_gym.scenario.scene import Motion


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"detector": "dgsn"}, "dsgn"),
        ({"detector": None}, "a detector is"),
        ({"detector": {"name": "dsgn", "weigths": "FILE"}}, 'mean "weights"'),
        ({"detector": "replayed"}, "needs the argument"),
        ({"detector": {"name": "scan_obstacles", "step": "a"}}, "cannot be made"),
        ({"planner": "astr"}, "astar"),
        ({"planner": 7}, "a planner is"),
        ({"planner": {"name": "astar", "node_limit": "many"}}, "node_limit takes"),
        ({"validator": "threshold"}, "thresholds"),
        ({"validator": "likelihood"}, "needs the argument 'model'"),
        ({"validator": {"name": "thresholds", "rat": 0.1}}, 'mean "rate"'),
        ({"validator": {"name": "thresholds", "rate": 2}}, "from 0 to 1, got 2"),
        ({"validator": {"name": "thresholds", "criterion": "errror"}}, 'mean "error"'),
        ({"clean": "street"}, "leave it out"),
        ({"scenarios": "mixd"}, "mixed"),
        ({"scenarios": {"source": "mixed", "splitt": "val"}}, "split"),
        ({"motion": "statik"}, "static"),
        ({"motion": "classifier"}, "none is here"),
        ({"score_threshold": 1.5}, r"from 0 to 1, got 1\.5"),
    ],
    ids=str,
)
def test_a_slip_is_told_before_anything_is_made(wrong: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ConfigurationError, match=complaint):
        Parts(**wrong)


@pytest.mark.parametrize(
    "parts",
    [
        {"detector": {"name": "dsgn", "weights": "/no/such/file.safetensors"}},
        {"detector": {"name": "pixor", "weights": __file__}},
        {"validator": {"name": "thresholds", "thresholds": "/no/such/table.json"}},
        {"validator": {"name": "likelihood", "model": __file__}},
    ],
    ids=["detector-missing", "detector-broken", "validator-missing", "validator-broken"],
)
def test_a_file_that_cannot_be_read_is_told_before_scenes_are_made(parts: dict[str, Any]) -> None:
    with pytest.raises(DataError):
        Parts(**parts)


def test_a_detector_of_2d_boxes_is_no_detector_of_a_car() -> None:
    with pytest.raises(ConfigurationError, match="2D boxes"):
        Parts(detector=SimpleNamespace(name="flat", image_only=True, detect=None))


def test_the_part_that_the_agent_plays_is_not_named() -> None:
    assert Parts(detector=None, agent=Kind.DETECTOR).detector is None


def test_the_car_has_the_parts_that_were_named() -> None:
    parts = Parts(
        detector="oracle",
        planner={"name": "gbfs", "node_limit": 77},
        motion="truth",
        score_threshold=0.6,
    )
    pipeline, planner = parts.pipeline(), parts.made_planner()
    assert pipeline.detector.name == "oracle"
    assert (pipeline.motion, pipeline.score_threshold) == (Motion.TRUTH, 0.6)
    assert (pipeline.attack, pipeline.classifier, pipeline.validator) == (None, None, None)
    assert isinstance(planner, MotionPrimitivePlanner)
    assert planner == pipeline.planner
    assert (planner.algorithm, planner.node_limit) == (Algorithm.GBFS, 77)


def test_live_parts_are_taken_as_they_are() -> None:
    planner = MotionPrimitivePlanner()
    parts = Parts(detector="oracle", planner=planner)
    assert parts.made_planner() is planner
    assert parts.pipeline().planner is planner


def test_scenes_without_a_validator_are_all_played(quick: dict[str, Any]) -> None:
    parts = Parts(**quick)
    validator, scenes = parts.validator_and_scenes()
    assert validator is None
    assert [scene.id for scene in scenes.scenes.scenes] == [
        scene.id for scene in parts.scenes().scenes.scenes
    ]


FORKED = """
import json, sys, gymnasium as gym
detector = {"name": "dsgn", "weights": "shipped"}
many = gym.make_vec("avsec_gym:avsec/PerturbationAttack-v0", num_envs=2,
                    vectorization_mode="async", scenarios=sys.argv[1], detector=detector)
many.call("known_size")
many.close()
print("done")
"""


def test_forked_processes_make_networks_after_their_parent(quick: dict[str, Any]) -> None:
    """The vector environment makes one for itself; its processes then have no threads of torch."""
    done = subprocess.run(
        [sys.executable, "-c", FORKED, quick["scenarios"]],
        capture_output=True,
        text=True,
        timeout=120,
        env=os.environ | {"OMP_NUM_THREADS": "2"},
    )
    assert done.stdout.strip() == "done", done.stderr
