"""Train an agent with several seeds at some budgets, and judge it beside all baselines.

    python -m studies.attackers.trained_agents GhostObject-v1 --budgets 256 1024 --runs runs/ghosts
    python -m studies.attackers.trained_agents ClosedLoopAttack-v0 --budgets 20480 --runs runs/loop

As `avsec agents train` and `avsec agents evaluate --budgets` do, in two processes.  Each baseline
is searched with as many environment steps as an agent learns from.  Trainings, agents and groups of
baselines are parts; a part that is finished is kept in --runs, so that a command that was stopped
goes on there.  Remove the folder where sources have changed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from avsec_gym.agents.agent_folder import read_agent_card
from avsec_gym.agents.comparison import AgentComparison, pooled
from avsec_gym.agents.configuration import configuration_of, shipped_variants
from avsec_gym.console import progress
from avsec_gym.worker_processes import each_in_processes
from studies.answer import answer
from studies.attackers.agent_parts import is_judged, judging_of, rows_of, training_of
from studies.attackers.agent_plan import AgentPlan, Part, in_scenes, rows_in_order


def compare(options: argparse.Namespace) -> dict[str, Any]:
    """Train, judge, compare; what is done is kept.

    Args:
        options: Those of `main`.
    """
    plan = plan_of(options)
    untrained = [part for part in plan.trainings if not plan.is_trained(part)]
    in_processes(training_of, plan, untrained, options.workers, "trainings")
    unjudged = [part for part in plan.parts if not is_judged(plan, part)]
    in_processes(judging_of, plan, unjudged, options.workers, "agents and groups of baselines")
    return result(plan)


def plan_of(options: argparse.Namespace) -> AgentPlan:
    """What the options ask for."""
    entry = configuration_of(options.env, options.algo, options.config, options.variant)
    if options.scenes:
        entry = in_scenes(entry, *options.scenes)
    return AgentPlan(
        entry, tuple(sorted(options.budgets)), options.seeds, options.episodes, options.runs
    )


def in_processes(
    prepare: Callable[[AgentPlan], Callable[[Part], None]],
    plan: AgentPlan,
    parts: Sequence[Part],
    workers: int,
    what: str,
) -> None:
    """Do parts, side by side.

    Args:
        prepare: Function that makes what does a part.
        plan: The comparison.
        parts: What is not done yet.
        workers: The number of processes.
        what: What is counted.
    """
    work = each_in_processes(partial(prepare, plan), parts, workers, threads=1, folder=plan.folder)
    with progress(what) as shown:
        for done, _ in enumerate(work, start=1):
            shown(done, len(parts))


def result(plan: AgentPlan) -> dict[str, Any]:
    """The comparisons of all budgets, as JSON.

    Args:
        plan: The comparison, all of whose parts are done.
    """
    comparisons = []
    for budget in plan.budgets:
        parts = list(rows_in_order(plan, budget))
        rows = [row for part in parts for row in rows_of(plan, part)]
        agents = [plan.agent(part) for part in parts if isinstance(part.who, int)]
        pools = pooled(agents, rows[: len(agents)])
        comparisons.append(AgentComparison(plan.entry.env, budget, rows, pools).to_json())
    cards = [read_agent_card(plan.agent_folder(part)) for part in plan.trainings]
    return {
        "env": plan.entry.env,
        "algorithm": plan.entry.algorithm,
        "entry": plan.entry.entry(),
        "seeds": plan.seeds,
        "episodes": plan.episodes,
        "training_seconds": round(sum(card.seconds for card in cards)),
        "budgets": comparisons,
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("env", help="id of the environment")
    parser.add_argument("--algo", default="ppo", help="how it learns")
    parser.add_argument("--config", type=Path, help="file of the entry; without: the package's")
    parser.add_argument("--variant", choices=shipped_variants(), help="of the package's entries")
    parser.add_argument(
        "--scenes", nargs=2, metavar=("LEARNED", "HELD_OUT"), help="sources of other scenes"
    )
    parser.add_argument("--budgets", type=int, nargs="+", required=True, help="environment steps")
    parser.add_argument("--seeds", type=int, default=5, help="trainings at each budget")
    parser.add_argument("--episodes", type=int, default=200, help="held-out episodes")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--runs", type=Path, required=True, help="folder of what is kept")
    parser.add_argument("--json", type=Path, help="file of the result; without: standard output")
    return answer(parser.parse_args(arguments), compare)


if __name__ == "__main__":
    sys.exit(main())
