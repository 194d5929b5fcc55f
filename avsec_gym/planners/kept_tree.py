"""A planner that keeps its search tree, for pictures."""

from __future__ import annotations

from dataclasses import replace

from avsec_gym.planners.planner import MotionPrimitivePlanner, Planner


def with_tree(planner: Planner) -> Planner:
    """The same planner; its plans have their search trees, if it is one that can keep them."""
    if isinstance(planner, MotionPrimitivePlanner):
        return replace(planner, keep_tree=True)
    return planner
