"""What `avsec drive` prints: a line for each setting, with intervals and the speed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from avsec_gym import console

if TYPE_CHECKING:
    from avsec_gym.drives.drive_folder import DriveFolder
    from avsec_gym.drives.summary import Mean, SettingSummary


def steps_per_second(folder: DriveFolder, summary: list[SettingSummary]) -> dict[str, float | None]:
    """Steps of each setting in a second of one process, planner included."""
    taken = dict.fromkeys((each.setting for each in summary), 0.0)
    for id, row in folder.rows.items():
        taken[row["setting"]] += folder.seconds.get(id, 0.0)
    return {
        each.setting: each.steps / taken[each.setting] if taken[each.setting] else None
        for each in summary
    }


def drive_report(
    out: Path, summary: list[SettingSummary], speeds: dict[str, float | None]
) -> dict[str, Any]:
    """What ``--json`` prints."""
    return {
        "out": str(out),
        "settings": [
            {**each.to_json(), "steps_per_second": speeds[each.setting]} for each in summary
        ],
    }


def print_settings(summary: list[SettingSummary], speeds: dict[str, float | None]) -> None:
    """Print a line for each setting."""
    alarms = any(each.rates["alarm"].count for each in summary)
    rates = ["at_fault", "goal", "hard_braking", *(["alarm"] if alarms else [])]
    console.print_table(
        f"drives under each setting: {summary[0].drives}; % and means with 95 % intervals",
        [
            "setting",
            "drives",
            "at-fault collisions",
            "goal reached",
            "brakes hard",
            *(["alarm raised"] if alarms else []),
            "NAVSIM score",
            f"score against {summary[0].setting}",
            "steps/s",
        ],
        [
            [
                each.setting,
                str(each.drives),
                *(
                    console.percent(share.rate, list(share.interval or ()) or None)
                    for share in (each.rates[name] for name in rates)
                ),
                _number(each.navsim_score),
                _number(each.differences.get("navsim_score")),
                "–" if (speed := speeds[each.setting]) is None else f"{speed:.1f}",
            ]
            for each in summary
        ],
    )


def _number(mean: Mean | None) -> str:
    if mean is None:
        return "–"
    if mean.interval is None:
        return f"{mean.value:.2f}"
    low, high = mean.interval
    return f"{mean.value:.2f} ({low:.2f} to {high:.2f})"
