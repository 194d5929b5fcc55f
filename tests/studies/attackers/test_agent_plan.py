"""What is trained and judged at each budget."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from avsec_gym.agents.baselines import GROUPS
from avsec_gym.agents.configuration import configuration_of
from avsec_gym.errors import ConfigurationError
from studies.attackers.agent_plan import AgentPlan, Part, fitted, in_scenes
from studies.attackers.trained_agents import main
from studies.catalogue import STUDIES

GHOSTS = configuration_of("GhostObject-v1", "ppo")


@pytest.mark.parametrize(
    ("budget", "count", "batch"), [(256, 2, 16), (4096, 32, 64), (262_144, 256, 512)]
)
def test_small_budgets_have_small_rollouts(budget: int, count: int, batch: int) -> None:
    own = fitted(GHOSTS, budget)
    assert (own.n_envs, own.arguments["batch_size"], own.n_timesteps) == (count, batch, budget)
    rollout = own.n_envs * own.arguments["n_steps"]
    assert budget % rollout == 0
    assert budget // rollout >= 16
    assert rollout % batch == 0


def test_random_actions_take_a_quarter_of_a_small_budget() -> None:
    own = fitted(configuration_of("PatchAttack-v0", "sac"), 256)
    assert own.arguments["learning_starts"] == 64


def test_scenes_are_named_anew_and_all_else_stays() -> None:
    entry = configuration_of("FaculaAttack-v0", "ppo", variant="aimed")
    own = in_scenes(entry, "a", "b")
    assert own.env_kwargs["scenarios"] == {"source": "a", "contested": True}
    assert own.held_out_kwargs == own.env_kwargs | {"scenarios": {"source": "b", "contested": True}}
    assert own.env_kwargs["radii"] == entry.env_kwargs["radii"]
    # A folder has no parts of assets and no split; instants of connected vehicles are all played.
    patch = in_scenes(configuration_of("PatchAttack-v0", "ppo"), "a", "b")
    assert patch.env_kwargs["scenarios"] == {"source": "a", "contested": True}
    connected = in_scenes(configuration_of("ConnectedSpoofing-v0", "ppo"), "a", "b")
    assert connected.held_out_kwargs["scenarios"] == {"source": "b"}


def test_a_budget_that_is_no_whole_rollouts_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="not a multiple of"):
        AgentPlan(GHOSTS, (300,), 5, 200, tmp_path)
    with pytest.raises(ConfigurationError, match="two trainings"):
        AgentPlan(GHOSTS, (256,), 1, 200, tmp_path)


def test_every_agent_and_group_of_baselines_is_a_part(tmp_path: Path) -> None:
    plan = AgentPlan(GHOSTS, (256, 1024), 3, 200, tmp_path)
    assert plan.trainings[0] == Part(1024, 0)
    assert len(plan.trainings) == 6
    assert len(plan.parts) == 2 * (3 + len(GROUPS))
    names = [part.name for part in plan.parts]
    assert len(set(names)) == len(names)
    assert not any(" " in name or "," in name for name in names)
    # Another number of episodes is another result.
    more = replace(plan, episodes=400)
    assert plan.asked(Part(256, "rules")) != more.asked(Part(256, "rules"))


AGENTS = STUDIES["agents"].shows


@pytest.mark.parametrize("name", AGENTS)
def test_the_studies_ask_for_what_the_protocol_does(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Five seeds, of policies on images three; 200 episodes or more; budgets that fit."""
    from studies.attackers import trained_agents

    plans: list[AgentPlan] = []
    monkeypatch.setattr(
        trained_agents, "compare", lambda options: plans.append(trained_agents.plan_of(options))
    )
    words = list(STUDIES[name].steps[-1].filled({"runs": [str(tmp_path)]}))
    assert words[:2] == ["-m", "studies.attackers.trained_agents"]
    words[words.index("--json") + 1] = str(tmp_path / "out.json")
    assert main(words[2:]) == 0
    (plan,) = plans
    on_images = plan.entry.policy == "MultiInputPolicy"
    assert plan.seeds == (3 if on_images else 5)
    assert plan.episodes >= 200
    assert plan.entry.env_kwargs["scenarios"] != plan.entry.held_out_kwargs["scenarios"]
    assert f"{name}.json" in STUDIES[name].writes[0]
