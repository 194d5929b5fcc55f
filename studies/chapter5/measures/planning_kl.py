"""Planning KL divergence: how much a belief changes what the car would do.

After Philion, Kar and Fidler, "Learning to Evaluate Perception Models Using Planner-Centric
Metrics", CVPR 2020: a planner that sees the detections spreads the probability of being somewhere
over the ground at each later time; the measure sums over time how far that is, as a
Kullback-Leibler divergence, from what the same planner would do if it saw the truth.

How this departs from it: there the planner is a network, trained on what people drove.  Here it is
this project's, a search that returns one trajectory; so that it has probabilities, every chain of
its motion primitives of two seconds has one in proportion to exp(-cost / temperature), by the cost
that A* itself orders by.  A chain that touches a believed object costs so much more that the car
gives up before: that it plans nothing, and stops, costs all the time that the goal is open, and
counts as a place of its own.  All this remains possible, so that divergences stay finite.  Nothing
is learned, and nothing but believed objects differs between the two.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.scenario.planning_scenario import PlanningScenario
from studies.chapter5.measures.trajectory_bundle import TrajectoryBundle, trajectory_bundle

TEMPERATURE = 0.1
"""Seconds, a time step: by how much a chain is slower that is taken 1/e as often."""
CONTACT = 3.0
"""Seconds that a chain costs more that touches something: more than giving up, whatever else."""
CELL = 0.5
"""Metres: side of the cells over which positions are counted."""


def planning_kl(
    truth: PlanningScenario, believed: PlanningScenario, bundle: TrajectoryBundle | None = None
) -> float:
    """How far the believed scenario moves the car from what it would do in the true one.

    Args:
        truth: The problem as it is.
        believed: The same start and goal among the objects that perception reports; all obstacles
            are rectangles.
        bundle: `trajectory_bundle` of both, where it is known.

    Returns:
        Nats, summed over the time steps of two seconds; 0 where both do the same.
    """
    bundle = trajectory_bundle(truth) if bundle is None else bundle
    p, q = (chances(bundle, scenario) for scenario in (truth, believed))
    return summed_divergence(p, q, occupied_cells(bundle))


def chances(bundle: TrajectoryBundle, scenario: PlanningScenario) -> Floats:
    """The probability of each trajectory, and last that of giving up, shape (B + 1,)."""
    giving_up = (scenario.last_step - scenario.start.step) * scenario.dt
    cost = np.append(bundle.cost + CONTACT * bundle.touching(scenario), giving_up)
    weight = np.exp((cost.min() - cost) / TEMPERATURE)
    return weight / weight.sum()


def occupied_cells(bundle: TrajectoryBundle) -> NDArray[np.int64]:
    """The number of the cell in which each trajectory is at each time step, shape (T - 1, B + 1).

    The start, which all share, is left out; one that is in its goal stays where it entered.  The
    last column is that of a car that gives up, which is in no other's cell.
    """
    many, count = bundle.index.shape
    step = np.minimum(np.arange(1, count)[:, None], bundle.lengths - 1)
    cells = np.floor(bundle.nodes[:, :2] / CELL).astype(np.int64)
    _, of_node = np.unique(cells, axis=0, return_inverse=True)
    numbers = of_node.reshape(-1)[bundle.index[np.arange(many), step]]
    return np.pad(numbers, ((0, 0), (0, 1)), constant_values=numbers.max() + 1).astype(np.int64)


def summed_divergence(p: Floats, q: Floats, cells: NDArray[np.int64]) -> float:
    """Kullback-Leibler divergence of positions, summed over time steps.

    Args:
        p: Probability of each of B trajectories by the truth.
        q: The same by the belief, above 0 wherever p is.
        cells: Cell of each trajectory at each time step, shape (T, B).

    Returns:
        Sum over steps of ``sum p_t log(p_t / q_t)`` over cells, nats.

    Example:
        >>> two = np.array([[0, 0], [0, 1]])  # Together at first, then apart.
        >>> round(summed_divergence(np.array([0.5, 0.5]), np.array([0.9, 0.1]), two), 4)
        0.5108
    """
    total = 0.0
    for row in cells:
        own, other = np.bincount(row, p), np.bincount(row, q)
        known = own > 0
        total += float((own[known] * np.log(own[known] / other[known])).sum())
    return max(total, 0.0)
