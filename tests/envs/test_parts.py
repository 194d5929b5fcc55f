"""The parts of environments: refused at once where they cannot be, made as they are named."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
from dataclasses import fields
from types import SimpleNamespace
from typing import Any

import gymnasium as gym
import pytest
from gymnasium.envs.registration import load_env_creator

from avsec_gym.envs.parts import Parts
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner
from avsec_gym.registration import CATALOGUE, EnvironmentEntry
from avsec_gym.registry import Kind
from avsec_gym.scenario.scene import Motion
from avsec_gym.validation.response import Response


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"detector": "dgsn"}, "dsgn"),
        ({"detector": None}, "a detector of 3D boxes is"),
        ({"detector": {"name": "dsgn", "weigths": "FILE"}}, 'mean "weights"'),
        ({"detector": "replayed"}, "needs the argument"),
        ({"detector": {"name": "scan_obstacles", "step": "a"}}, "step takes a number"),
        ({"planner": "astr"}, "astar"),
        ({"planner": 7}, "a planner is"),
        ({"planner": {"name": "astar", "node_limit": "many"}}, "node_limit takes"),
        ({"validator": "threshold"}, "thresholds"),
        ({"validator": "likelihood"}, "needs the argument 'model'"),
        ({"validator": {"name": "thresholds", "rat": 0.1}}, 'mean "rate"'),
        ({"validator": {"name": "thresholds", "rate": 2}}, "from 0 to 1, got 2"),
        ({"validator": {"name": "thresholds", "criterion": "errror"}}, 'mean "error"'),
        ({"clean": "street"}, "leave it out"),
        ({"attack": "faculla"}, 'mean "facula"'),
        ({"attack": "tesis_pgd"}, 'mean "thesis_pgd"'),
        ({"attack": {"name": "facula", "radus": 3}}, 'mean "radius"'),
        ({"attack": "random_ghosts"}, "no attack on frames"),
        ({"classifier": "smal"}, 'mean "small"'),
        ({"classifier": "vgg16"}, "needs the argument 'weights'"),
        ({"selector": 3}, "a selector is"),
        ({"response": "stopp"}, 'mean "stop"'),
        ({"motion": "statik"}, "static"),
        ({"motion": "classifier"}, "none is here"),
        ({"score_threshold": 1.5}, r"from 0 to 1, got 1\.5"),
        ({"road": "onw"}, 'mean "own"'),
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


def test_the_part_that_the_agent_plays_need_not_be_named() -> None:
    assert Parts(detector=None, agent=Kind.DETECTOR).detector is None


def test_an_attack_by_gradient_knows_a_detector() -> None:
    with pytest.raises(ConfigurationError, match=r"detector=\"dsgn\", or another.*transferred"):
        Parts(detector=None, attack="fgsm", agent=Kind.DETECTOR)


def test_a_classifier_decides_what_moves() -> None:
    assert Parts(motion="classifier", classifier="small").motion == Motion.CLASSIFIER


def test_the_car_has_the_parts_that_were_named(quick: dict[str, Any]) -> None:
    parts = Parts(
        scenarios=quick["scenarios"],
        detector="oracle",
        planner={"name": "gbfs", "node_limit": 77},
        motion="truth",
        score_threshold=0.6,
        response="drop",
    )
    pipeline, scenes = parts.car()
    assert pipeline.detector.name == "oracle"
    assert (pipeline.motion, pipeline.score_threshold) == (Motion.TRUTH, 0.6)
    assert (pipeline.attack, pipeline.classifier, pipeline.validator) == (None, None, None)
    assert pipeline.response == Response.DROP
    assert isinstance(pipeline.planner, MotionPrimitivePlanner)
    assert (pipeline.planner.algorithm, pipeline.planner.node_limit) == (Algorithm.GBFS, 77)
    assert len(scenes) == 3


def test_live_parts_are_taken_as_they_are(quick: dict[str, Any]) -> None:
    planner = MotionPrimitivePlanner()
    parts = Parts(scenarios=quick["scenarios"], detector="oracle", planner=planner)
    assert parts.car()[0].planner is planner


def test_an_agent_takes_the_detectors_place_and_the_attack_knows_the_judged_one(
    quick: dict[str, Any],
) -> None:
    agent = SimpleNamespace(name="agent", detect=None)
    parts = Parts(scenarios=quick["scenarios"], detector="oracle", agent=Kind.DETECTOR)
    pipeline, _ = parts.car(agent)
    assert pipeline.detector is agent
    assert pipeline.victim.name == "oracle"


EVERY = [
    point
    for entry in CATALOGUE
    for point in (entry.entry_point, entry.vector_entry_point)
    if point is not None
]
OWN = {
    "scenarios": {"layouts", "raw", "connected", "drives"},
    "detector": {"scan_obstacles", None},
    "attack": {"thesis"},
    "motion": {"truth"},
}
"""Defaults that docs/environments.md lists as other ones, with the reason."""


@pytest.mark.parametrize("point", EVERY)
def test_parts_have_the_same_names_and_defaults_everywhere(point: str) -> None:
    """Each environment takes every part, or refuses it with a reason."""
    environment = load_env_creator(point)
    taken = environment.taken_parts  # type: ignore[attr-defined]
    shown = inspect.signature(environment).parameters
    for part in fields(Parts):
        if part.name == "agent":
            continue
        if part.name in taken.refused:
            assert part.name not in shown
            with pytest.raises(ConfigurationError, match=f"takes no '{part.name}': "):
                environment(**{part.name: None})
        else:
            default = shown[part.name].default
            assert default == part.default or default in OWN[part.name]


VECTORISED = [entry for entry in CATALOGUE if entry.vector_entry_point is not None]
OF_MANY = {"num_envs", "max_episode_steps"}
"""Arguments of vectorised environments alone."""
OF_SINGLE_ONES = {"frame_size"}
"""Of what vectorised environments refuse: frames to observe."""


@pytest.mark.parametrize("entry", VECTORISED, ids=lambda entry: entry.id)
def test_a_vectorised_environment_has_the_defaults_of_the_single_one(
    entry: EnvironmentEntry,
) -> None:
    """Both write them out, for whoever reads a signature."""

    def defaults(point: str | None, but: set[str]) -> dict[str, Any]:
        shown = inspect.signature(load_env_creator(str(point))).parameters
        return {name: each.default for name, each in shown.items() if name not in but}

    many = defaults(entry.vector_entry_point, OF_MANY)
    assert many == defaults(entry.entry_point, OF_SINGLE_ONES)


@pytest.mark.parametrize("point", EVERY)
def test_an_argument_that_is_none_is_asked_about(point: str) -> None:
    with pytest.raises(ConfigurationError, match=r'no argument .*Did you mean "scenarios"'):
        load_env_creator(point)(scenaros="mixed")


def test_former_arguments_name_the_new_ones() -> None:
    with pytest.raises(ConfigurationError, match=r'.image. any more: observation="both"'):
        gym.make("avsec/PatchAttack-v0", image=True)
    with pytest.raises(ConfigurationError, match='"contested": True'):
        gym.make("avsec/FaculaAttack-v0", contested=True)


FORKED = """
import json, sys, gymnasium as gym
detector = {"name": "dsgn", "weights": "shipped"}
many = gym.make_vec("avsec_gym:avsec/PerturbationAttack-v0", num_envs=2,
                    vectorization_mode="async", scenarios=sys.argv[1], detector=detector)
many.call("known_size")
many.close()
print("done")
"""


@pytest.mark.slow
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
