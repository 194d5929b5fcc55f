"""The page studies/results/driving_safety.md, from the numbers of `report`."""

from __future__ import annotations

from typing import Any

from avsec_gym.experiments.thesis import NAMES, SAFE_DRIVING_WITH_GROUND_TRUTH, SAFETY
from avsec_gym.planners.planner import Algorithm
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_sets import WITHOUT_CARS

_RATES = ("success", "collision", "safe driving", "swept collision")
_NAMES = {Algorithm.ASTAR: "A*", Algorithm.GBFS: "GBFS"}
_THESIS = {
    (str(planner), str(intention)): rate
    for (planner, intention), rate in SAFE_DRIVING_WITH_GROUND_TRUTH.items()
}


def page(results: dict[str, Any]) -> str:
    """The results as Markdown."""
    lines = [
        "# Driving safety on the labelled scenarios of KITTI",
        "",
        f"{results['scenarios']} scenarios of KITTI object/training, each driven left, straight"
        " and right, planned with motion primitives that the project generates. Made by",
        "",
        "```",
        "python -m studies.driving_safety.report --scenarios DIR --detections DIR",
        "```",
        "",
        "and, one variant at a time, by `avsec evaluate --kitti ROOT --scenarios DIR"
        " [--detections DIR]`. Rates in %, with 95 % Wilson intervals; numbers in"
        " [driving_safety.json](driving_safety.json).",
        "",
        *_ground_truth(results["ground_truth"]),
        *_less_known(results),
        *_towards_the_thesis(results["other_planners"]),
        "### Start speeds drawn from the thesis' ranges",
        "",
        "Uniform in 22..29 km/h (street) and 40..47 km/h (highway), kept exactly, with primitives"
        " that start there (`--draw-start-speed`).",
        "",
        *_table(
            ["planner", "intention", "success", "collision", "safe driving"],
            [[*_head(row), *_three(row)] for row in results["drawn_start_speeds"]],
        ),
        "",
        *_detector(results),
        *_beside_truth(results),
        "### Score thresholds (A*, safe driving)",
        "",
        *_sweep_table(results["sweep"]),
        "",
        "## Remarks on the data",
        "",
        *(f"- {remark}" for remark in results["remarks"]),
    ]
    return "\n".join(lines) + "\n"


def _ground_truth(truth: list[dict[str, Any]]) -> list[str]:
    """Rates, means and reasons where the planner is given what is really there."""
    return [
        "## Ground truth in",
        "",
        *_table(
            ["planner", "intention", *_RATES, "thesis, safe"],
            [
                [*_head(row), *_four(row), f"{100 * _THESIS[row['planner'], row['intention']]:.1f}"]
                for row in truth
            ],
        ),
        "",
        _swept_remark(truth),
        "",
        "Means over planned scenarios: time to the goal (g), path length, CommonRoad's cost SM1.",
        "",
        *_table(
            ["planner", "intention", "time [s]", "path [m]", "SM1"],
            [
                [
                    *_head(row),
                    f"{row['mean_travel_time']:.2f}",
                    f"{row['mean_path_length']:.1f}",
                    f"{row['mean_sm1_cost']:.0f}",
                ]
                for row in truth
            ],
        ),
        "",
        "Every scenario without a plan has its reason. *Unreachable* is a certificate: the search"
        " exhausted every sequence of the primitives; *goal occupied* means that objects leave no"
        " room in the goal region for its whole time window.",
        "",
        *_table(
            ["planner", "intention", "no plan because"],
            [[*_head(row), _reasons(row)] for row in truth],
        ),
        "",
    ]


def _less_known(results: dict[str, Any]) -> list[str]:
    """The rates by group, and those without knowledge of the motion."""
    seeds = [row["seed"] for row in results["speeds_of_others"]]
    return [
        "### By group of scenarios (A*, safe driving)",
        "",
        *_group_table(results),
        "",
        "### When the planner does not know which objects move",
        "",
        "It plans as if everything stood; the collision check lets the moving objects move.",
        "",
        *_table(
            ["planner", "intention", "success", "collision", "safe driving"],
            [[*_head(row), *_three(row)] for row in results["motion_unknown"]],
        ),
        "",
        "The speeds of the moving objects are drawn from a seed. The safe driving rate of A* over"
        f" the seeds {min(seeds)} to {max(seeds)}: " + _spread(results["speeds_of_others"]) + ".",
        "",
    ]


def _towards_the_thesis(rows: list[dict[str, Any]]) -> list[str]:
    """The rates with planners that are, step by step, more like the authors'."""
    return [
        "### Why the rates lie above the thesis'",
        "",
        "Step by step towards what the authors used, A*. They give two sets of street primitives,"
        " with the speeds 6 and 8 m/s or 6 m/s alone; commonroad-search tests a primitive for"
        " collisions to its end even where it has reached the goal.",
        "",
        *_table(
            ["planner", *(f"{intention}, safe driving" for intention in Intention)],
            [
                [
                    variant,
                    *(_rate(row, "safe_driving_rate") for row in rows if row["variant"] == variant),
                ]
                for variant in dict.fromkeys(row["variant"] for row in rows)
            ]
            + [["thesis", *(f"{100 * _THESIS['astar', str(i)]:.1f}" for i in Intention)]],
        ),
        "",
    ]


def _detector(results: dict[str, Any]) -> list[str]:
    """The rates with detections as input."""
    detected = [row for row in results["detections"] if row["planner"] == "astar"]
    return [
        f"## A real detector in: {results['detector']}",
        "",
        f"Detections with scores of {results['score_threshold']:g} or more; the planner takes every"
        " detected object to stand. Trajectories are checked against the ground truth.",
        "",
        *_table(
            [
                "intention",
                *_RATES,
                *(f"thesis, {name} (stereo)" for name in NAMES.values()),
            ],
            [
                [
                    row["intention"],
                    *_four(row),
                    *(
                        f"{100 * SAFETY[detector, 'unattacked', intention].safe:.1f}"
                        for detector in NAMES
                        for intention in [Intention(row["intention"])]
                    ),
                ]
                for row in detected
            ],
        ),
        "",
    ]


def _beside_truth(results: dict[str, Any]) -> list[str]:
    """Detections against the ground truth, scenario by scenario."""
    return [
        "Beside the ground truth, on the same scenarios (A* and GBFS; detections minus ground"
        " truth in percentage points, 95 % paired bootstrap intervals):",
        "",
        *_table(
            [
                "planner",
                "intention",
                "success",
                "collision",
                "safe driving",
                "became unsafe",
                "became safe",
                "McNemar p",
            ],
            [
                [
                    *_head(row),
                    *(
                        _rate(row, name)
                        for name in ("success_rate", "collision_rate", "safe_driving_rate")
                    ),
                    str(row["became_unsafe"]),
                    str(row["became_safe"]),
                    "–" if row["mcnemar_p"] is None else f"{row['mcnemar_p']:.1e}",
                ]
                for row in results["differences"]
            ],
        ),
        "",
        "What became unsafe (A*): "
        + "; ".join(
            f"{row['intention']} {row['became_unsafe']} ({row['collisions']} collisions,"
            f" {row['no_plan']} without a plan)"
            for row in results["flips"]
        )
        + ". `avsec evaluate ... --out DIR` draws them.",
        "",
        "If the planner knew how the detected objects move (`--motion truth`), A*:",
        "",
        *_table(
            ["intention", "success", "collision", "safe driving"],
            [
                [row["intention"], *_three(row)]
                for row in results["detections_motion_known"]
                if row["planner"] == "astar"
            ],
        ),
        "",
    ]


def _table(columns: list[str], rows: list[list[str]]) -> list[str]:
    return [
        "| " + " | ".join(columns) + " |",
        "|" + " --- |" * len(columns),
        *("| " + " | ".join(row) + " |" for row in rows),
    ]


def _head(row: dict[str, Any]) -> list[str]:
    return [_NAMES[Algorithm(row["planner"])], row["intention"]]


def _three(row: dict[str, Any]) -> list[str]:
    return [_rate(row, name) for name in ("success_rate", "collision_rate", "safe_driving_rate")]


def _four(row: dict[str, Any]) -> list[str]:
    return [*_three(row), _rate(row, "swept_collision_rate")]


def _swept_remark(rows: list[dict[str, Any]]) -> str:
    planned = sum(row["planned"] for row in rows)
    between = sum(row["swept_collisions"] - row["collisions"] for row in rows)
    return (
        "*Collision* is the thesis' check: at every time step of 0.1 s. *Swept collision* also"
        " counts what is touched between two steps, where the vehicle and the objects move on"
        f" linearly (to a millimetre): {between} of {planned} plans touch something there that no"
        " time step shows. Success and safe driving go by the time steps, as in the thesis."
    )


def _rate(row: dict[str, Any], name: str) -> str:
    if row[name] is None:
        return "–"
    low, high = row[f"{name}_interval"]
    return f"{100 * row[name]:.1f} ({100 * low:.1f} to {100 * high:.1f})"


def _reasons(row: dict[str, Any]) -> str:
    words = (f"{name.replace('_', ' ')} {count}" for name, count in row["failures"].items())
    return ", ".join(words) or "–"


def _group_table(results: dict[str, Any]) -> list[str]:
    def cells(rows: list[dict[str, Any]]) -> list[str]:
        return [_rate(row, "safe_driving_rate") for row in rows if row["planner"] == "astar"]

    rows = [
        [group, str(rows[0]["scenarios"]), *cells(rows)]
        for group, rows in results["groups"].items()
    ]
    kept = results["without_scenes_without_cars"]
    rows.append([f"all but {WITHOUT_CARS}", str(kept[0]["scenarios"]), *cells(kept)])
    return _table(["group", "scenarios", *map(str, Intention)], rows)


def _spread(rows: list[dict[str, Any]]) -> str:
    parts = []
    for intention in Intention:
        rates = [100 * row["safe_driving_rate"] for row in rows if row["intention"] == intention]
        parts.append(f"{intention} {min(rates):.1f} to {max(rates):.1f}")
    return ", ".join(parts)


def _sweep_table(rows: list[dict[str, Any]]) -> list[str]:
    thresholds = list(dict.fromkeys(row["score_threshold"] for row in rows))
    table = [
        [
            f"{threshold:.2f}",
            *(
                _rate(row, "safe_driving_rate")
                for row in rows
                if row["score_threshold"] == threshold
            ),
        ]
        for threshold in thresholds
    ]
    return _table(["scores from", *map(str, Intention)], table)
