"""The parts of environments: refused at once where they cannot be, made as they are named."""

from __future__ import annotations

from typing import Any

import pytest

from avsec_gym.envs.parts import Parts
from avsec_gym.errors import ConfigurationError
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner
from avsec_gym.registry import Kind
from avsec_gym.scenario.scene import Motion


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"detector": "dgsn"}, "dsgn"),
        ({"detector": None}, "a detector is"),
        ({"planner": "astr"}, "astar"),
        ({"planner": 7}, "a planner is"),
        ({"validator": "threshold"}, "thresholds"),
        ({"clean": "street"}, "leave it out"),
        ({"scenarios": "mixd"}, "mixed"),
        ({"scenarios": {"source": "mixed", "splitt": "val"}}, "split"),
        ({"motion": "statik"}, "static"),
        ({"motion": "classifier"}, "none is here"),
        ({"score_threshold": 1.5}, r"\[0, 1\], got 1\.5"),
    ],
    ids=str,
)
def test_a_slip_is_told_before_anything_is_made(wrong: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ConfigurationError, match=complaint):
        Parts(**wrong)


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
