"""The parts of a comparison of agents: a training, or episodes of an agent or of baselines.

They are done in processes, and what they find is kept as JSON.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.agents.arena import Played
from avsec_gym.agents.compared_agent import ComparedAgent
from avsec_gym.agents.judged_episodes import JudgedEpisodes
from avsec_gym.agents.training import TrainingSitting, train_agent
from avsec_gym.storage.json_files import read_json
from avsec_gym.storage.regular_files import is_file
from avsec_gym.storage.text_files import write_text
from studies.attackers.agent_plan import AgentPlan, Part, fitted

_KEPT = "parts"
_SEED = 0
"""Seed of the first held-out episode, and of the searches."""


def training_of(plan: AgentPlan) -> Callable[[Part], None]:
    """What trains an agent, or goes on with it.

    Args:
        plan: The comparison.
    """

    def train(part: Part) -> None:
        assert isinstance(part.who, int)
        entry = fitted(plan.entry, part.budget)
        sitting = TrainingSitting(part.budget, resume=True)
        train_agent(entry, plan.agent_folder(part), part.who, sitting)

    return train


def judging_of(plan: AgentPlan) -> Callable[[Part], None]:
    """What plays the episodes of a part, and keeps what came of them.

    Args:
        plan: The comparison, whose agents are trained.
    """

    @cache
    def episodes() -> JudgedEpisodes:
        # Scenes, and what was computed of them, are kept in the process.
        return JudgedEpisodes.of(plan.entry, plan.episodes, _SEED)

    def judge(part: Part) -> None:
        if isinstance(part.who, int):
            rows = episodes().of_agents([plan.agent(part)])
        else:
            agent = plan.untrained(part.budget)
            rows = episodes().of_baselines(agent, part.budget, groups=[part.who])
        found = {"asked": plan.asked(part), "rows": [_row_json(row) for row in rows]}
        write_text(_place(plan, part), json.dumps(found, indent=1) + "\n", overwrite=True)

    return judge


def is_judged(plan: AgentPlan, part: Part) -> bool:
    """Whether what came of a part is kept, of the agents and the entry as they are now."""
    place = _place(plan, part)
    return is_file(place) and bool(_read(place)["asked"] == _plain(plan.asked(part)))


def rows_of(plan: AgentPlan, part: Part) -> list[ComparedAgent]:
    """What came of a part that is judged.

    Raises:
        DataError: It is not kept, or damaged.
    """
    return [_row_of(row) for row in _read(_place(plan, part))["rows"]]


def _place(plan: AgentPlan, part: Part) -> Path:
    return plan.folder / _KEPT / f"{plan.entry.algorithm}_{part.name}.json"


def _read(place: Path) -> Any:
    return read_json(place, remedy="Remove it, and it is made anew.")


def _plain(value: Any) -> Any:
    """As it comes back from a file."""
    return json.loads(json.dumps(value))


def _row_json(row: ComparedAgent) -> dict[str, Any]:
    training = None if row.training is None else _played_json(row.training)
    return {
        "name": row.name,
        "queries": row.queries,
        "played": _played_json(row.played),
        "training": training,
    }


def _row_of(row: Any) -> ComparedAgent:
    training = None if row["training"] is None else _played_of(row["training"])
    return ComparedAgent(row["name"], _played_of(row["played"]), row["queries"], training)


def _played_json(played: Played) -> dict[str, Any]:
    return {name: getattr(played, name).tolist() for name in Played.__dataclass_fields__}


def _played_of(columns: Any) -> Played:
    return Played(**{name: np.array(columns[name]) for name in Played.__dataclass_fields__})
