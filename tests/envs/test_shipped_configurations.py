"""Every shipped configuration of an agent learns for a few steps, in small scenes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import torch

from avsec_gym.agents.configuration import (
    AgentConfiguration,
    configuration_of,
    shipped_configurations,
    shipped_variants,
)
from avsec_gym.agents.learner import make_learner
from tests.envs.test_catalogue import arguments
from tests.envs.test_ppo_learns import CHEAP, RENDERED

SHORT: dict[str, dict[str, Any]] = {
    "ppo": {"n_steps": 8, "batch_size": 8, "n_epochs": 1},
    "sac": {"learning_starts": 4, "batch_size": 4, "buffer_size": 20, "gradient_steps": 1},
}
"""What keeps a training short; networks, discounts and observations are those of the entry."""


def listed() -> list[Any]:
    """Algorithm, environment and variant of every entry; slow are variants and rendered sensors."""
    found = []
    for variant in (None, *shipped_variants()):
        for env, algorithms in shipped_configurations(variant).items():
            marks = [pytest.mark.slow] if env in RENDERED or variant else []
            found += [
                pytest.param(
                    algorithm, env, variant, marks=marks, id=f"{algorithm}-{env}-{variant}"
                )
                for algorithm in algorithms
            ]
    return found


def short(configuration: AgentConfiguration) -> AgentConfiguration:
    """The same in the small scenes of the catalogue's tests."""
    cheap = arguments(configuration.env) | CHEAP.get(configuration.env, {})
    cheap.pop("observation", None)  # The configuration's own, which its policy takes.
    if configuration.env == "avsec/ClosedLoopAttack-v0":
        cheap = {}  # Of a few drives, none is contested.
    if configuration.env in RENDERED:  # The small suites are of all assets.
        scenes = dict(configuration.env_kwargs["scenarios"])
        scenes.pop("assets", None)
        cheap = {"scenarios": scenes} | cheap
    return replace(
        configuration,
        n_envs=1,
        env_kwargs=configuration.env_kwargs | cheap,
        arguments=configuration.arguments | SHORT[configuration.algorithm],
    )


@pytest.mark.slow
@pytest.mark.parametrize(("algorithm", "env", "variant"), listed())
def test_a_shipped_configuration_learns(
    algorithm: str, env: str, variant: str | None, request: pytest.FixtureRequest
) -> None:
    if env in RENDERED:
        request.getfixturevalue("small_suite")
    configuration = short(configuration_of(env, algorithm, variant=variant))
    if variant == "images" and env == "avsec/ClosedLoop-v0":  # Layouts have no sensors.
        drives = {"scenarios": {"source": "drives", "count": 1}, "duration": 0.5}
        configuration = replace(configuration, env_kwargs=configuration.env_kwargs | drives)
    learner = make_learner(configuration, 0)
    before = {name: value.clone() for name, value in learner.policy.state_dict().items()}
    learner.learn(16)  # Two rollouts: what falls linearly is 0 after the last.
    after = learner.policy.state_dict()
    assert all(torch.isfinite(value).all() for value in after.values())
    assert any(not torch.equal(value, before[name]) for name, value in after.items())
    learner.env.close()
