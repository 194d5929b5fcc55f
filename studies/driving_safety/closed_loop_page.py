"""The page of `closed_loop`, as Markdown.

Run ``python -m studies.driving_safety.closed_loop_page --results FOLDER --out PAGE``: those of
`PARTS` are shown that are there.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from avsec_gym.drives.summary import Mean
from avsec_gym.errors import DataError
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.report.markdown_table import UNKNOWN, markdown_table, number
from avsec_gym.storage.json_files import read_json
from avsec_gym.storage.regular_files import is_file
from avsec_gym.storage.text_files import write_text
from studies.answer import exit_code
from studies.driving_safety.closed_loop import (
    FEWEST,
    TRUTH,
    CollisionAtFault,
    JudgedModel,
    LoopTable,
    LoopTables,
    PooledRanking,
    Ranking,
)

PARTS = ("closed_loop_scenes", "closed_loop_rendered")
"""Studies whose results the page shows."""
_COMMAND = "Make it with `python -m studies.closed_loop`, or take the file away."
_SETS = {
    "labels": "The first scenarios of the labelled ones, straight on",
    "drives": "Procedural drives, every intention that a scene has a lane for",
    "tracking": "KITTI tracking, straight on; ego motion estimated from standing objects",
    "rendered": "Contested drives on rendered sensors: clean, attacked, defended",
    "rendered_pgd": "The same drives under gradients, without and with the defence",
    "models": "Error models on the same drives, and DSGN, rendered",
}
_RATES = {
    "collision": "collision",
    "at_fault": "at fault",
    "goal": "goal reached",
    "hard_braking": "brakes hard",
    "alarm": "alarm raised",
}


def closed_loop_page(result: LoopTables) -> str:
    """The page.

    Args:
        result: The result of `closed_loop`.
    """
    lines = [
        "# Driving on, with what the car believes",
        "",
        "The planner drives for up to 8 s, replanning every 0.5 s from the state that was really"
        " reached (`avsec drive`). A setting is what the car believes: everything (`truth`),"
        " nothing (`blind`), the truth with the errors of a detector, left alone or under an"
        " attack (its [error model](error_models.md)), or what a detector finds in rendered sensor"
        " data, which a validator may judge (`defended`); a car that has stood by its alarms for"
        " 2 s is handed over to a human, and the drive ends there. All settings drive the same"
        " scenes with the same seeds. In brackets: 95 % intervals, of clusters: drives of one"
        " scene, windows of one recording. First plan safe: the single query's answer, the first"
        " plan alone held against what is there (at constant velocity). Score: NAVSIM's, and its"
        " paired difference"
        " from truth.",
        "",
        *_contested(result),
    ]
    for name, title in _SETS.items():
        table: LoopTable | None = getattr(result, name)
        if table is not None:
            lines += [f"## {title}", "", *_table(table), ""]
            if any(each.summary.setting == TRUTH for each in table.settings):
                lines += [*_at_fault(table), "", _ranking(table.ranking), ""]
    lines += _pooled(result.pooled) if result.pooled else []
    if result.judged_models:
        lines += _judged(result.judged_models)
    return "\n".join(lines)


def _contested(result: LoopTables) -> list[str]:
    driven = result.models or result.rendered
    if result.looked_at is None or driven is None:
        return []
    return [
        f"What is rendered are {driven.clusters} contested drives: the first of"
        f" {result.looked_at} procedural drives in which a car that sees nothing is to blame for a"
        " collision and one that knows the truth reaches its goal. Their rates are those of drives"
        " in which it matters what is seen, not of traffic at large, and truth is faultless there"
        " by that rule. `defended_unattacked` shows what false stops cost.",
        "",
    ]


def _pooled(pooled: Sequence[PooledRanking]) -> list[str]:
    rows = [
        [
            f"`{each.of}`" if each.of else "all",
            " < ".join(each.first_plans),
            " < ".join(each.loop),
            UNKNOWN
            if each.ranking.rho is None
            else _mean(Mean(each.ranking.rho, each.ranking.interval)),
        ]
        for each in pooled
    ]
    return [
        "## Does the ranking of the single query survive, over all error models' drives?",
        "",
        "Settings from the safest to the most dangerous, and Spearman's correlation of the shares"
        " behind both orders; of one detector it is over three settings.",
        "",
        *markdown_table(["of", "unsafe first plans", "collisions of drives", "correlation"], rows),
        "",
    ]


def _judged(models: Sequence[JudgedModel]) -> list[str]:
    rows = [
        [
            f"`{each.model}`",
            str(each.rendered.of),
            _rate(each.rendered),
            _rate(each.modelled),
            "yes" if each.believed else "no",
        ]
        for each in models
    ]
    return [
        "## Which error models are believed",
        "",
        "A model is believed where its share of drives with a collision lies within the interval of"
        f" the rendered one, on {FEWEST} scenes or more. Drives by any other state nothing of its"
        " detector.",
        "",
        *markdown_table(
            ["model", "drives", "collision, rendered, %", "collision, model, %", "believed"], rows
        ),
        "",
    ]


def _table(table: LoopTable) -> list[str]:
    alarms = any(each.summary.rates["alarm"].count for each in table.settings)
    rates = [rate for rate in _RATES if rate != "alarm" or alarms]
    columns = ["setting", "drives", "first plan safe, %"]
    columns += [f"{_RATES[rate]}, %" for rate in rates]
    rows = [
        [
            f"`{each.summary.setting}`",
            str(each.summary.drives),
            _rate(each.first_plan),
            *(_rate(each.summary.rates[rate]) for rate in rates),
            _mean(each.summary.navsim_score),
            _mean(each.summary.differences.get("navsim_score")),
        ]
        for each in table.settings
    ]
    return [
        f"{table.clusters} clusters.",
        "",
        *markdown_table([*columns, "score", "score against truth"], rows),
    ]


def _at_fault(table: LoopTable) -> list[str]:
    """A line for each collision at fault of the car that knows the truth."""
    if not table.truth_at_fault:
        return ["The car that knows the truth collides nowhere by its own fault."]
    return [
        f"- `{each.scenario}` ({each.intention}), under truth: {_certificates(each)}"
        for each in table.truth_at_fault
    ]


def _certificates(each: CollisionAtFault) -> str:
    found = []
    if each.unavoidable_after is not None:
        found.append(f"no car could have avoided it beyond {each.unavoidable_after:g} s")
    if each.no_plan_since is not None:
        found.append(f"from {each.no_plan_since:g} s on a complete search finds no plan without it")
    if not found:
        return "no certificate that it could not be avoided."
    return f"{'; '.join(found)}."


def _ranking(ranking: Ranking) -> str:
    if ranking.rho is None:
        return "The settings with errors cannot be ranked: a rate is the same for all of them."
    return (
        "Does the ranking of the single query survive the loop? Spearman's correlation, over the"
        " settings with errors, of unsafe first plans with collisions of drives:"
        f" {_mean(Mean(ranking.rho, ranking.interval))}."
    )


def _rate(share: Share) -> str:
    if share.rate is None or share.interval is None:
        return UNKNOWN
    low, high = (number(100 * bound, 1) for bound in share.interval)
    return f"{number(100 * share.rate, 1)} [{low}, {high}]"


def _mean(mean: Mean | None) -> str:
    if mean is None:
        return UNKNOWN
    if mean.interval is None:
        return number(mean.value, 2)
    low, high = (number(bound, 2) for bound in mean.interval)
    return f"{number(mean.value, 2)} [{low}, {high}]"


def read_parts(folder: Path, parts: Sequence[str] = PARTS) -> LoopTables:
    """The results of some of `PARTS` in a folder, as one.

    Raises:
        DataError: There is none of them, or one is damaged.
    """
    found: dict[str, object] = {}
    for path in (folder / f"{name}.json" for name in parts):
        if not is_file(path):
            continue
        try:
            part = row_of(LoopTables, read_json(path, remedy=_COMMAND))
        except (ValueError, KeyError, TypeError) as error:
            raise DataError(
                "This is no result of the closed loop.", path=path, remedy=_COMMAND
            ) from error
        own = {each.name: getattr(part, each.name) for each in fields(LoopTables)}
        found |= {name: value for name, value in own.items() if value}
    if not found:
        raise DataError("No part of the closed loop has been made.", path=folder, remedy=_COMMAND)
    return LoopTables(**found)  # type: ignore[arg-type]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--results", type=Path, required=True, help="folder of the parts' JSON")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS, help="default: all")
    parser.add_argument("--out", type=Path, required=True, help="the page")
    options = parser.parse_args(arguments)

    def work() -> None:
        text = closed_loop_page(read_parts(options.results, options.parts))
        write_text(options.out, text, overwrite=True)

    return exit_code(work)


if __name__ == "__main__":
    sys.exit(main())
