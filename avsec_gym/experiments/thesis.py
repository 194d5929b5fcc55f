"""Figures of the thesis, to stand beside ours (section 5.4; rates as fractions)."""

from __future__ import annotations

from avsec_gym.planners.planner import Algorithm
from avsec_gym.scenario.intention import Intention

SAFE_DRIVING_WITH_GROUND_TRUTH = {
    (Algorithm.ASTAR, Intention.LEFT): 0.897,
    (Algorithm.ASTAR, Intention.STRAIGHT): 0.980,
    (Algorithm.ASTAR, Intention.RIGHT): 0.852,
    (Algorithm.GBFS, Intention.LEFT): 0.879,
    (Algorithm.GBFS, Intention.STRAIGHT): 0.980,
    (Algorithm.GBFS, Intention.RIGHT): 0.823,
}
"""Safe driving rate when the planner gets the ground truth."""

SAFE_DRIVING_UNATTACKED = {
    "DSGN": {Intention.LEFT: 0.877, Intention.STRAIGHT: 0.958, Intention.RIGHT: 0.830},
    "Stereo R-CNN": {Intention.LEFT: 0.870, Intention.STRAIGHT: 0.953, Intention.RIGHT: 0.821},
}
"""Safe driving rate with a detector that nobody attacks, A*."""
