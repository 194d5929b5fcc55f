"""What every environment reports of the car in `info`: always all keys, scalars only."""

from __future__ import annotations

import math
from typing import Any

from avsec_gym.metrics.smallest_distance import smallest_distance
from avsec_gym.pipeline import Episode
from avsec_gym.planners.vehicle import BMW_320I


def episode_info(episode: Episode | None, scenario: str, intention: str) -> dict[str, Any]:
    """The thesis' three answers, what the trajectory measures, the outcome, and where.

    Args:
        episode: The planned trajectory and its check; None at reset, whose outcome is ``reset``.
        scenario: The id of the scene.
        intention: The lane that the car wants to reach.

    Returns:
        `planned`, and the same as `success`, the thesis' word for a plan that was found, also one
        that collides: `safe` is what most readers mean, and `is_success`, which environments add,
        is the agent's; `collision`, `safe`; `cost` (planned time, s), `path_length` (m),
        `smallest_distance` (of the car from anything real at a time step, m; 0 in a collision,
        infinite where nothing is there) and `cost_sm1` (CommonRoad's SM1), nan where unplanned;
        `outcome`, `scenario` and `intention`.
    """
    record = None if episode is None else episode.record
    planned = record is not None and record.planned
    nearest = math.nan
    if planned and episode is not None and episode.plan.trajectory is not None:
        trajectory, first = episode.plan.trajectory, episode.plan.first_step
        nearest = smallest_distance(trajectory, episode.truth, BMW_320I, first)
    return {
        "planned": planned,
        "success": planned,
        "collision": record is not None and record.collision,
        "safe": record is not None and record.safe,
        "cost": math.nan if record is None else float(record.cost),
        "path_length": math.nan if record is None else float(record.path_length),
        "smallest_distance": nearest,
        "cost_sm1": math.nan if record is None else float(record.sm1_cost),
        "outcome": "reset" if record is None else record.outcome,
        "scenario": scenario,
        "intention": str(intention),
    }
