"""Driving-safety records and the thesis' three rates (section 5.3.2).

m_suc = k_trj / k_dts      m_cls = k_cls / k_trj      m_saf = (k_trj - k_cls) / k_dts
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from avsec_gym.metrics.clustered_shares import clustered_interval, design_effect
from avsec_gym.metrics.collision_check import first_contact
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.metrics.swept_contact import first_swept_contact
from avsec_gym.metrics.trajectory_cost import path_length, sm1_cost, travel_time
from avsec_gym.planners.plan import Plan
from avsec_gym.planners.vehicle import BMW_320I, Vehicle
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import PlanningScenario

SAFE, COLLISION, UNPLANNED = "safe", "collision", "unplanned"
"""The outcomes of an episode."""


@dataclass(frozen=True)
class SafetyRecord:
    """What became of one scenario."""

    scenario: str
    intention: str
    outcome: str
    """``safe``, ``collision`` or ``unplanned``."""
    cost: float
    """Time to the goal, s; nan if unplanned."""
    expanded: int
    path_length: float
    """m; nan if unplanned."""
    travel_time: float
    """s; nan if unplanned."""
    reason: str | None = None
    """Why nothing was planned."""
    goal_occupied: float = float("nan")
    """Seconds of the goal's time window without room in it; nan if planned."""
    collision_time: float = float("nan")
    """s after the start; nan without a collision."""
    collision_object: int | None = None
    """Row of the touched object among the ground truth's obstacles."""
    sm1_cost: float = float("nan")
    """CommonRoad's cost SM1; nan if unplanned."""
    swept_collision: bool | None = None
    """Whether the trajectory touches something real at or between time steps, see `swept_contact`;
    the outcome goes by the time steps alone, as in the thesis.  None where it was not checked."""

    @property
    def planned(self) -> bool:
        """A trajectory was found, whether it collides or not."""
        return self.outcome != UNPLANNED

    @property
    def collision(self) -> bool:
        """The trajectory touches something real."""
        return self.outcome == COLLISION

    @property
    def safe(self) -> bool:
        """Planned and free of collisions."""
        return self.outcome == SAFE

    def to_json(self) -> dict[str, Any]:
        """All fields; what is not a number becomes None."""
        return {
            name: None if isinstance(value, float) and math.isnan(value) else value
            for name, value in asdict(self).items()
        }


RecordCluster = Callable[[SafetyRecord], str]
"""A rule that names the cluster of alike records that a record belongs to."""


def scenario_of(record: SafetyRecord) -> str:
    """The usual cluster: all records of one scenario, whatever the intention or attack."""
    return record.scenario


def judge(
    plan: Plan, scenario: PlanningScenario, truth: Obstacles, vehicle: Vehicle = BMW_320I
) -> SafetyRecord:
    """Hold a plan against what is really there.

    Args:
        plan: The planner's answer.
        scenario: The planning scenario that it answers.
        truth: The real obstacles.
        vehicle: The vehicle that drives.
    """
    intention = "" if scenario.intention is None else str(scenario.intention)
    if plan.trajectory is None:
        return SafetyRecord(
            scenario.id,
            intention,
            UNPLANNED,
            cost=math.nan,
            expanded=plan.expanded,
            path_length=math.nan,
            travel_time=math.nan,
            reason=None if plan.reason is None else str(plan.reason),
            goal_occupied=plan.goal_occupied,
        )
    contact = first_contact(plan.trajectory, truth, vehicle, plan.first_step)
    return SafetyRecord(
        scenario.id,
        intention,
        SAFE if contact is None else COLLISION,
        cost=plan.cost,
        expanded=plan.expanded,
        path_length=path_length(plan.trajectory),
        travel_time=travel_time(plan.trajectory, scenario.dt),
        collision_time=(
            math.nan if contact is None else (contact.step - plan.first_step) * scenario.dt
        ),
        collision_object=None if contact is None else contact.obstacle,
        sm1_cost=sm1_cost(plan.trajectory, scenario),
        swept_collision=(
            contact is not None
            or first_swept_contact(plan.trajectory, truth, vehicle, plan.first_step) is not None
        ),
    )


@dataclass(frozen=True)
class SafetyRates:
    """The three rates over a set of scenarios, each with its 95 % interval.

    It is Wilson's; where several episodes share a scenario, it is widened by the design effect of
    the scenarios (`avsec_gym.metrics.clustered_shares`).
    """

    scenarios: int
    """The number of scenarios, k_dts."""
    planned: int
    """The number of planned episodes, k_trj."""
    collisions: int
    """The number of collisions, k_cls."""
    failures: dict[str, int]
    """Unplanned scenarios by reason."""
    mean_path_length: float
    """m, over planned scenarios; nan without any."""
    mean_travel_time: float
    """s, over planned scenarios; nan without any."""
    mean_sm1_cost: float
    """CommonRoad's cost SM1, over planned scenarios; nan without any."""
    swept_collisions: int | None = None
    """Planned scenarios that touch something at or between time steps; None if not checked."""
    design_effects: Mapping[str, float] | None = None
    """Design effects of each rate, by its name: how many times as much it varies as if all episodes
    were independent; None: each episode is a cluster of its own."""

    @classmethod
    def of(
        cls, records: Iterable[SafetyRecord], cluster: RecordCluster = scenario_of
    ) -> SafetyRates:
        """Count records.

        Args:
            records: The records that are counted.
            cluster: The cluster that a record belongs to: its scenario, which its intentions and
                attacks share, or more, such as the drive that several scenarios are of.
        """
        records = list(records)
        together = len({cluster(record) for record in records}) < len(records)
        planned = [record for record in records if record.planned]
        return cls(
            scenarios=len(records),
            planned=len(planned),
            collisions=sum(record.collision for record in planned),
            # A planner of a plug-in may give no reason.
            failures=dict(
                sorted(Counter(r.reason or "unknown" for r in records if not r.planned).items())
            ),
            mean_path_length=_mean([record.path_length for record in planned]),
            mean_travel_time=_mean([record.travel_time for record in planned]),
            mean_sm1_cost=_mean([record.sm1_cost for record in planned]),
            swept_collisions=(
                None
                if any(record.swept_collision is None for record in planned)
                else sum(bool(record.swept_collision) for record in planned)
            ),
            design_effects=_design_effects(records, planned, cluster) if together else None,
        )

    @property
    def success_rate(self) -> float:
        """m_suc; nan without scenarios."""
        return _share(self.planned, self.scenarios)

    @property
    def collision_rate(self) -> float:
        """m_cls; nan where nothing was planned."""
        return _share(self.collisions, self.planned)

    @property
    def swept_collision_rate(self) -> float:
        """Share of the planned that touch something at or between time steps; nan if unknown."""
        if self.swept_collisions is None:
            return math.nan
        return _share(self.swept_collisions, self.planned)

    @property
    def safe_driving_rate(self) -> float:
        """m_saf; nan without scenarios."""
        return _share(self.planned - self.collisions, self.scenarios)

    def to_json(self) -> dict[str, Any]:
        """Rates as fractions with intervals; a rate without cases is None."""
        safe = self.planned - self.collisions
        found: dict[str, Any] = {
            "scenarios": self.scenarios,
            "success_rate": _number(self.success_rate),
            "success_rate_interval": self._interval(SUCCESS, self.planned, self.scenarios),
            "collision_rate": _number(self.collision_rate),
            "collision_rate_interval": self._interval(COLLIDED, self.collisions, self.planned),
            "safe_driving_rate": _number(self.safe_driving_rate),
            "safe_driving_rate_interval": self._interval(SAFE_DRIVING, safe, self.scenarios),
            "planned": self.planned,
            "collisions": self.collisions,
            "failures": self.failures,
            "mean_path_length": _number(self.mean_path_length),
            "mean_travel_time": _number(self.mean_travel_time),
            "mean_sm1_cost": _number(self.mean_sm1_cost),
            "swept_collisions": self.swept_collisions,
            "swept_collision_rate": _number(self.swept_collision_rate),
            "swept_collision_rate_interval": (
                None
                if self.swept_collisions is None
                else self._interval(SWEPT, self.swept_collisions, self.planned)
            ),
        }
        if self.design_effects is not None:
            found["design_effects"] = dict(self.design_effects)
        return found

    def _interval(self, rate: str, hits: int, cases: int) -> list[float] | None:
        if not cases:
            return None
        if self.design_effects is None:
            return [*wilson_interval(hits, cases)]
        return [*clustered_interval(hits, cases, self.design_effects[rate])]


SUCCESS, COLLIDED, SAFE_DRIVING = "success_rate", "collision_rate", "safe_driving_rate"
SWEPT = "swept_collision_rate"
"""Names of rates."""


def _design_effects(
    records: Sequence[SafetyRecord], planned: Sequence[SafetyRecord], cluster: RecordCluster
) -> dict[str, float]:
    """Of each rate that has cases."""
    hits: dict[str, tuple[Sequence[SafetyRecord], list[bool]]] = {
        SUCCESS: (records, [record.planned for record in records]),
        COLLIDED: (planned, [record.collision for record in planned]),
        SAFE_DRIVING: (records, [record.safe for record in records]),
        SWEPT: (planned, [bool(record.swept_collision) for record in planned]),
    }
    return {
        name: design_effect(flags, [cluster(record) for record in cases])
        for name, (cases, flags) in hits.items()
        if flags
    }


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else math.nan


def _share(part: int, whole: int) -> float:
    return part / whole if whole else math.nan


def _number(value: float) -> float | None:
    return None if math.isnan(value) else value
