"""Show what `studies.attackers.trained_agents` found in each game: who wins; writes agents.md.

Run ``python -m studies.attackers.who_wins --results studies/results``, after the commands that
write the games' JSON (``python -m studies.agents`` makes all).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.report.markdown_table import interval, markdown_table, number
from avsec_gym.storage.json_files import read_json
from avsec_gym.storage.regular_files import is_file
from avsec_gym.storage.text_files import write_text
from studies.answer import exit_code

GAMES = {
    "agents_ghosts": ("ghosts that detections are given", "features"),
    "agents_closed_loop": ("ghosts and hidden objects, over time", "features"),
    "agents_laser": ("a small spot of light in a camera", "features"),
    "agents_laser_images": ("the same spot", "the image, beside features"),
    "agents_connected": ("a scan pasted into one of several vehicles'", "features"),
    "agents_patch": ("a patch in both images", "features"),
    "agents_perturbation": ("gradients of another detector's loss", "features"),
    "agents_lidar": ("bogus points in the scan", "features"),
    "agents_defender": ("nothing: its car's detector is under the thesis' PGD", "features"),
}
"""Results by their names: what is attacked with, and what the agent sees."""
LONGER = {"agents_closed_loop": "agents_closed_loop_long"}
"""Games whose larger budgets are results of their own."""
AGENT, BASELINE, UNDECIDED = "the agent", "the baseline", "undecided"
_WINNERS = {"agent": AGENT, "baseline": BASELINE, "undecided": UNDECIDED}
_PAGE = "agents.md"

Result = Mapping[str, Any]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--results", type=Path, required=True, help="folder of JSON and page")
    options = parser.parse_args(arguments)

    def work() -> None:
        folder: Path = options.results
        write_text(folder / _PAGE, page(read_results(folder)), overwrite=True)

    return exit_code(work)


def read_results(folder: Path) -> dict[str, Result]:
    """The games that have been played, in the order of `GAMES`.

    Args:
        folder: Folder of the JSON files.

    Raises:
        DataError: None has been, or a file is damaged.
    """
    remedy = "python -m studies.agents makes all of them."

    def read(name: str) -> Any:
        place = folder / f"{name}.json"
        return read_json(place, remedy=remedy) if is_file(place) else None

    found: dict[str, Result] = {}
    for name in GAMES:
        parts = [part for part in map(read, (name, LONGER.get(name, ""))) if part is not None]
        if parts:
            budgets = [budget for part in parts for budget in part["budgets"]]
            found[name] = {**parts[0], "budgets": budgets}
    if not found:
        raise DataError("No game has been played.", path=folder, remedy=remedy)
    return found


def page(results: Mapping[str, Result]) -> str:
    """Markdown: who wins in each game at each budget, then all baselines at the largest.

    Args:
        results: Results of `trained_agents` by the names of `GAMES`.
    """
    won = [name for name, found in results.items() if winner(found["budgets"][-1]) == AGENT]
    lines = [
        "# Who wins: agents and searched baselines",
        "",
        "An agent learns with several seeds from a budget of environment steps; each baseline is"
        " searched with as many. All play the same held-out episodes, in scenes that nothing was"
        " learned or searched in. Shown are interquartile means of the success rate of 20 episodes,"
        " over all seeds, with 95 % stratified bootstrap intervals. The best baseline is the one"
        " that wins most often in training episodes. Who wins has intervals that are apart, an"
        " agent from those of all baselines"
        " ([how agents are judged](../../docs/agents.md#judging)).",
        "",
        f"At the largest budget the agent wins in {len(won)} of {len(results)} games"
        f"{': ' + ', '.join(map(_title, won)) if won else ''}.",
        "",
        *markdown_table(
            ["game", "attacks with", "sees", "steps", "agent, %", "best baseline",
             "best baseline, %", "probability of improvement, %", "who wins"],
            [row for name, found in results.items() for row in _summary(name, found)],
        ),
        "",
        "*Features* are numbers about the car, its goal and the nearest objects; a policy that"
        " reads them sees no pixel, also where the attack is one on images. A step of"
        " `ClosedLoopAttack` is a frame, and a drive has 80 at most; in the other games it is a"
        " query. The probability of improvement is that of the agent over the best baseline.",
    ]  # fmt: skip
    for name, found in results.items():
        lines += ["", *_in_full(name, found)]
    return "\n".join(lines) + "\n"


def winner(comparison: Result) -> str:
    """Who wins at a budget.

    Args:
        comparison: One of a result's budgets.
    """
    return _WINNERS[_pool(comparison)["winner"]]


def _summary(name: str, found: Result) -> list[list[str]]:
    """A row for each budget."""
    rows = []
    for comparison in found["budgets"]:
        pool, best = _pool(comparison), _best(comparison)
        rows.append(
            [
                _title(name),
                *GAMES[name],
                f"{comparison['budget']:,}",
                _percent(pool["interquartile_mean"], pool["interquartile_mean_interval"]),
                best["name"],
                _percent(best["interquartile_mean"], best["interquartile_interval"]),
                _percent(
                    pool["probability_of_improvement"], pool["probability_of_improvement_interval"]
                ),
                winner(comparison),
            ]
        )
    return rows


def _in_full(name: str, found: Result) -> list[str]:
    """All who played, at the largest budget."""
    comparison = found["budgets"][-1]
    pool = _pool(comparison)
    file = f"{name if len(found['budgets']) == 1 else LONGER.get(name, name)}.json"
    best = comparison["best_baseline"]
    rows = [
        [
            f"**{pool['name']}**",
            f"{pool['queries']:,}",
            number(100 * pool["success_rate"], 1),
            _percent(pool["interquartile_mean"], pool["interquartile_mean_interval"]),
            number(None, 1),
        ]
    ]
    for row in comparison["rows"]:
        training = row["training_success_rate"]
        rows.append(
            [
                f"{row['name']} (the best baseline)" if row["name"] == best else row["name"],
                f"{row['queries']:,}",
                _percent(row["success_rate"], row["success_interval"]),
                _percent(row["interquartile_mean"], row["interquartile_interval"]),
                number(None if training is None else 100 * training, 1),
            ]
        )
    return [
        f"## {_title(name)}",
        "",
        f"`{found['env']}`, {comparison['budget']:,} steps, {found['episodes']} episodes;"
        f" {found['entry']['policy']}, {found['algorithm'].upper()}; {_arguments(found['entry'])}."
        f" In numbers: [{file}]({file}).",
        "",
        *markdown_table(
            ["who", "steps", "success, %", "interquartile mean, %", "in training episodes, %"], rows
        ),
    ]


def _arguments(entry: Result) -> str:
    """What the environment of an entry is made with, but for its scenes."""
    given = {name: value for name, value in entry["env_kwargs"].items() if name != "scenarios"}
    words = ", ".join(f"{name}={value!r}" for name, value in given.items())
    return f"`{words}`" if words else "default arguments"


def _pool(comparison: Result) -> Result:
    """The trainings of all seeds together."""
    (pool,) = comparison["pooled"]
    found: Result = pool
    return found


def _best(comparison: Result) -> Result:
    """The best baseline."""
    found: Result = next(
        row for row in comparison["rows"] if row["name"] == comparison["best_baseline"]
    )
    return found


def _title(name: str) -> str:
    return name.removeprefix("agents_").replace("_", " ")


def _percent(value: float | None, bounds: Sequence[float] | None) -> str:
    """A share in percent, with its interval."""
    if value is None or bounds is None:
        return number(None if value is None else 100 * value, 1)
    return interval(100 * value, [100 * bound for bound in bounds])


if __name__ == "__main__":
    sys.exit(main())
