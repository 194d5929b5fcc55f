"""Planners as users type them: a name, one of a plug-in's too, or JSON with arguments."""

from __future__ import annotations

from avsec_gym.built_in_parts import ALL_PLANNERS
from avsec_gym.commands.named_part import named_part
from avsec_gym.errors import ConfigurationError
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner, Planner
from avsec_gym.registry import Kind, make


def named_planner(text: str) -> tuple[str, Planner]:
    """The planner, and the name that its results are filed under.

    Args:
        text: What was typed, such as ``astar``, ``mine``, or ``{"name": "mine", "patience": 3}``.

    Raises:
        ConfigurationError: There is none of that name, its arguments do not fit, or what a plug-in
            makes is none.
    """
    what = named_part(text, "--planner")
    planner = make(Kind.PLANNER, what)
    name = text if isinstance(what, str) else str(what["name"])
    if not callable(getattr(planner, "plan", None)):
        raise ConfigurationError(
            f"the planner {name!r} is a {type(planner).__name__} without plan(scenario)"
        )
    return name, planner


def named_planners(text: str) -> dict[str, Planner]:
    """The same by name, `ALL_PLANNERS` of the package among them; errors as above."""
    if text == ALL_PLANNERS:
        return {str(search): MotionPrimitivePlanner(search) for search in Algorithm}
    return dict([named_planner(text)])
