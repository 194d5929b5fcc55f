"""The page studies/results/driving_safety.md, from the numbers of `report`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

from avsec_gym.experiments.thesis import NAMES, SAFE_DRIVING_WITH_GROUND_TRUTH, SAFETY
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.planners.planner import Algorithm
from avsec_gym.report.markdown_table import UNKNOWN, markdown_table
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_sets import WITHOUT_CARS
from studies.driving_safety.rows import DifferenceRow, DrivingSafetyResults, RatesRow, VariantRow

_RATES = ("success", "collision", "safe driving", "swept collision")
_THREE = ("success_rate", "collision_rate", "safe_driving_rate")
_NAMES = {Algorithm.ASTAR: "A*", Algorithm.GBFS: "GBFS"}

K = TypeVar("K")


def page(results: DrivingSafetyResults) -> str:
    """The results as Markdown."""
    lines = [
        "# Driving safety on the labelled scenarios of KITTI",
        "",
        f"{results.scenarios} scenarios of KITTI object/training, each driven left, straight"
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
        *_ground_truth(results.ground_truth),
        *_less_known(results),
        *_towards_the_thesis(results.other_planners),
        "### Start speeds drawn from the thesis' ranges",
        "",
        "Uniform in 22..29 km/h (street) and 40..47 km/h (highway), kept exactly, with primitives"
        " that start there (`--draw-start-speed`).",
        "",
        *markdown_table(
            ["planner", "intention", "success", "collision", "safe driving"],
            [[*_head(row), *_three(row.rates)] for row in results.drawn_start_speeds],
        ),
        "",
        *_detector(results),
        *_beside_truth(results),
        "### Score thresholds (A*, safe driving)",
        "",
        *_sweep_table(_grouped((each.score_threshold, each.row) for each in results.sweep)),
        "",
        "## Remarks on the data",
        "",
        *(f"- {remark}" for remark in results.remarks),
    ]
    return "\n".join(lines) + "\n"


def _ground_truth(truth: Sequence[RatesRow]) -> list[str]:
    """Rates, means and reasons where the planner is given what is really there."""
    return [
        "## Ground truth in",
        "",
        *markdown_table(
            ["planner", "intention", *_RATES, "thesis, safe"],
            [
                [
                    *_head(row),
                    *_four(row.rates),
                    _of_thesis(row.planner, row.intention),
                ]
                for row in truth
            ],
        ),
        "",
        _swept_remark(truth),
        "",
        "Means over planned scenarios: time to the goal (g), path length, CommonRoad's cost SM1.",
        "",
        *markdown_table(
            ["planner", "intention", "time [s]", "path [m]", "SM1"],
            [
                [
                    *_head(row),
                    f"{row.rates.mean_travel_time:.2f}",
                    f"{row.rates.mean_path_length:.1f}",
                    f"{row.rates.mean_sm1_cost:.0f}",
                ]
                for row in truth
            ],
        ),
        "",
        "Every scenario without a plan has its reason. *Unreachable* is a certificate: the search"
        " exhausted every sequence of the primitives; *goal occupied* means that objects leave no"
        " room in the goal region for its whole time window.",
        "",
        *markdown_table(
            ["planner", "intention", "no plan because"],
            [[*_head(row), _reasons(row)] for row in truth],
        ),
        "",
    ]


def _less_known(results: DrivingSafetyResults) -> list[str]:
    """The rates by group, and those without knowledge of the motion."""
    seeds = [each.seed for each in results.speeds_of_others]
    return [
        "### By group of scenarios (A*, safe driving)",
        "",
        *_group_table(results),
        "",
        "### When the planner does not know which objects move",
        "",
        "It plans as if everything stood; the collision check lets the moving objects move.",
        "",
        *markdown_table(
            ["planner", "intention", "success", "collision", "safe driving"],
            [[*_head(row), *_three(row.rates)] for row in results.motion_unknown],
        ),
        "",
        "The speeds of the moving objects are drawn from a seed. The safe driving rate of A* over"
        f" the seeds {min(seeds)} to {max(seeds)}: "
        + _spread([each.row for each in results.speeds_of_others])
        + ".",
        "",
    ]


def _towards_the_thesis(planners: Sequence[VariantRow]) -> list[str]:
    """The rates with planners that are, step by step, more like the authors'."""
    rows = [
        [variant, *(_safe_driving(row.rates) for row in own)]
        for variant, own in _grouped((each.variant, each.row) for each in planners).items()
    ]
    rows.append(["thesis", *(_of_thesis(Algorithm.ASTAR, intention) for intention in Intention)])
    return [
        "### Why the rates lie above the thesis'",
        "",
        "Step by step towards what the authors used, A*. They give two sets of street primitives,"
        " with the speeds 6 and 8 m/s or 6 m/s alone; commonroad-search tests a primitive for"
        " collisions to its end even where it has reached the goal.",
        "",
        *markdown_table(
            ["planner", *(f"{intention}, safe driving" for intention in Intention)],
            rows,
        ),
        "",
    ]


def _detector(results: DrivingSafetyResults) -> list[str]:
    """The rates with detections as input."""
    detected = [row for row in results.detections if row.planner == Algorithm.ASTAR]
    return [
        f"## A real detector in: {results.detector}",
        "",
        f"Detections with scores of {results.score_threshold:g} or more; the planner takes every"
        " detected object to stand. Trajectories are checked against the ground truth.",
        "",
        *markdown_table(
            [
                "intention",
                *_RATES,
                *(f"thesis, {name} (stereo)" for name in NAMES.values()),
            ],
            [
                [
                    row.intention,
                    *_four(row.rates),
                    *(
                        f"{100 * SAFETY[detector, 'unattacked', row.intention].safe:.1f}"
                        for detector in NAMES
                    ),
                ]
                for row in detected
            ],
        ),
        "",
    ]


def _beside_truth(results: DrivingSafetyResults) -> list[str]:
    """Detections against the ground truth, scenario by scenario."""
    return [
        "Beside the ground truth, on the same scenarios (A* and GBFS; detections minus ground"
        " truth in percentage points, 95 % paired bootstrap intervals; p: McNemar's test, after"
        " Holm's correction for all rows):",
        "",
        *markdown_table(
            [
                "planner",
                "intention",
                "success",
                "collision",
                "safe driving",
                "became unsafe",
                "became safe",
                "McNemar p, corrected",
            ],
            [
                [
                    *_head(row),
                    *(_rate(getattr(row.paired, rate)) for rate in _THREE),
                    str(row.paired.became_unsafe),
                    str(row.paired.became_safe),
                    "–" if row.mcnemar_p_holm is None else f"{row.mcnemar_p_holm:.1e}",
                ]
                for row in results.differences
            ],
        ),
        "",
        "What became unsafe (A*): "
        + "; ".join(
            f"{row.intention} {row.became_unsafe} ({row.collisions} collisions,"
            f" {row.no_plan} without a plan)"
            for row in results.flips
        )
        + ". `avsec evaluate ... --out DIR` draws them.",
        "",
        "If the planner knew how the detected objects move (`--motion truth`), A*:",
        "",
        *markdown_table(
            ["intention", "success", "collision", "safe driving"],
            [
                [row.intention, *_three(row.rates)]
                for row in results.detections_motion_known
                if row.planner == Algorithm.ASTAR
            ],
        ),
        "",
    ]


def _head(row: RatesRow | DifferenceRow) -> list[str]:
    return [_NAMES[row.planner], row.intention]


def _three(rates: SafetyRates) -> list[str]:
    columns = rates.to_json()
    return [_rate(Estimate.of_columns(rate, columns)) for rate in _THREE]


def _four(rates: SafetyRates) -> list[str]:
    swept = Estimate.of_columns("swept_collision_rate", rates.to_json())
    return [*_three(rates), _rate(swept)]


def _safe_driving(rates: SafetyRates) -> str:
    return _three(rates)[-1]


def _swept_remark(rows: Sequence[RatesRow]) -> str:
    rates = [row.rates for row in rows]
    planned = sum(each.planned for each in rates)
    between = sum(
        each.swept_collisions - each.collisions
        for each in rates
        if each.swept_collisions is not None
    )
    return (
        "*Collision* is the thesis' check: at every time step of 0.1 s. *Swept collision* also"
        " counts what is touched between two steps, where the vehicle and the objects move on"
        f" linearly (to a millimetre): {between} of {planned} plans touch something there that no"
        " time step shows. Success and safe driving go by the time steps, as in the thesis."
    )


def _rate(rate: Estimate) -> str:
    if rate.value is None or rate.interval is None:
        return UNKNOWN
    low, high = rate.interval
    return f"{100 * rate.value:.1f} ({100 * low:.1f} to {100 * high:.1f})"


def _reasons(row: RatesRow) -> str:
    words = (f"{name.replace('_', ' ')} {count}" for name, count in row.rates.failures.items())
    return ", ".join(words) or "–"


def _group_table(results: DrivingSafetyResults) -> list[str]:
    def cells(rows: Sequence[RatesRow]) -> list[str]:
        return [_safe_driving(row.rates) for row in rows if row.planner == Algorithm.ASTAR]

    rows = [
        [group, str(rows[0].rates.scenarios), *cells(rows)]
        for group, rows in results.groups.items()
    ]
    kept = results.without_scenes_without_cars
    rows.append([f"all but {WITHOUT_CARS}", str(kept[0].rates.scenarios), *cells(kept)])
    return markdown_table(["group", "scenarios", *map(str, Intention)], rows)


def _spread(rows: Sequence[RatesRow]) -> str:
    parts = []
    for intention in Intention:
        own = [100 * row.rates.safe_driving_rate for row in rows if row.intention == intention]
        parts.append(f"{intention} {min(own):.1f} to {max(own):.1f}")
    return ", ".join(parts)


def _sweep_table(sweep: Mapping[float, Sequence[RatesRow]]) -> list[str]:
    rows = [
        [f"{threshold:.2f}", *(_safe_driving(row.rates) for row in rows)]
        for threshold, rows in sweep.items()
    ]
    return markdown_table(["scores from", *map(str, Intention)], rows)


def _grouped(rows: Iterable[tuple[K, RatesRow]]) -> dict[K, list[RatesRow]]:
    """The rows by what stands beside them, in the order in which that comes."""
    found: dict[K, list[RatesRow]] = {}
    for key, row in rows:
        found.setdefault(key, []).append(row)
    return found


def _of_thesis(planner: Algorithm, intention: Intention) -> str:
    """Safe driving with the ground truth, %."""
    return f"{100 * SAFE_DRIVING_WITH_GROUND_TRUTH[planner, intention]:.1f}"
