"""Who wins stands on the page by intervals that are apart."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.agents.agent_folder import AgentCard, TrainedAgent
from avsec_gym.agents.arena import Played
from avsec_gym.agents.compared_agent import ComparedAgent
from avsec_gym.agents.comparison import AgentComparison, pooled
from avsec_gym.agents.configuration import AgentConfiguration
from avsec_gym.errors import DataError
from studies.attackers.who_wins import (
    AGENT,
    BASELINE,
    GAMES,
    LONGER,
    UNDECIDED,
    page,
    read_results,
    winner,
)
from studies.catalogue import STUDIES
from studies.study import RESULTS, ROOT

ENTRY = AgentConfiguration("avsec/GhostObject-v1", "ppo", 1024, env_kwargs={"queries": 1})


def played(rate: float, seed: int) -> Played:
    won = np.random.default_rng(seed).random(400) < rate
    count = len(won)
    ones = np.ones(count, int)
    return Played(won, won - 0.04, ones, np.full(count, "left"), np.arange(count).astype(str))


def comparison(rate: float, budget: int = 1024) -> dict[str, Any]:
    """Two seeds that win so often, beside a baseline that wins half of the time."""
    cards = [
        AgentCard("avsec/GhostObject-v1", {}, {}, "ppo", seed, budget, 1.0, True, 1, "")
        for seed in range(2)
    ]
    agents = [TrainedAgent(f"ppo, seed {card.seed}", ENTRY, card, None) for card in cards]
    own = [
        ComparedAgent(agent.name, played(rate, seed), budget) for seed, agent in enumerate(agents)
    ]
    base = [
        ComparedAgent(name, played(share, 10), budget, played(share, 11))
        for name, share in (("random actions", 0.1), ("constant", 0.5))
    ]
    found = AgentComparison("avsec/GhostObject-v1", budget, own + base, pooled(agents, own))
    plain: dict[str, Any] = json.loads(json.dumps(found.to_json()))
    return plain


def result(*rates: float) -> dict[str, Any]:
    budgets = [comparison(rate, 1024 * 4**k) for k, rate in enumerate(rates)]
    return {
        "env": "avsec/GhostObject-v1",
        "algorithm": "ppo",
        "entry": ENTRY.entry(),
        "seeds": 2,
        "episodes": 400,
        "training_seconds": 1,
        "budgets": budgets,
    }


@pytest.mark.parametrize(("rate", "who"), [(0.8, AGENT), (0.2, BASELINE), (0.5, UNDECIDED)])
def test_who_wins_has_an_interval_apart(rate: float, who: str) -> None:
    assert winner(comparison(rate)) == who


def test_the_page_counts_the_games_that_the_agent_wins_at_the_largest_budget() -> None:
    text = page({"agents_ghosts": result(0.2, 0.8), "agents_laser": result(0.8, 0.5)})
    assert "the agent wins in 1 of 2 games: ghosts." in text
    rows = [line for line in text.splitlines() if line.startswith(("| ghosts |", "| laser |"))]
    assert [row.rpartition(" | ")[2] for row in rows] == [
        "the baseline |", "the agent |", "the agent |", "undecided |",
    ]  # fmt: skip
    assert "| constant (the best baseline) |" in text
    assert "`queries=1`" in text
    assert "sees no pixel" in text


def test_games_that_have_not_been_played_are_left_out(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="No game"):
        read_results(tmp_path)
    (tmp_path / "agents_ghosts.json").write_text(json.dumps(result(0.8)))
    assert list(read_results(tmp_path)) == ["agents_ghosts"]
    # Larger budgets of a game are results of their own, and one game on the page.
    (tmp_path / "agents_closed_loop.json").write_text(json.dumps(result(0.2)))
    (tmp_path / "agents_closed_loop_long.json").write_text(json.dumps(result(0.8)))
    found = read_results(tmp_path)
    assert list(found) == ["agents_ghosts", "agents_closed_loop"]
    assert len(found["agents_closed_loop"]["budgets"]) == 2
    assert "(agents_closed_loop_long.json)" in page(found)


def test_the_page_shows_the_studies_of_the_catalogue() -> None:
    study = STUDIES["agents"]
    assert set(study.shows) == {*GAMES, *LONGER.values()}
    for name in study.shows:
        assert STUDIES[name].writes == (f"{RESULTS}/{name}.json",)


def test_the_committed_page_is_that_of_the_committed_results() -> None:
    from studies.index import without_remark

    place = ROOT / RESULTS / "agents.md"
    if not place.is_file():
        pytest.skip("no game has been played yet")
    assert without_remark(place.read_text()) == page(read_results(place.parent))
