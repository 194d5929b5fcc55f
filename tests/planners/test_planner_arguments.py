"""Whatever is given for an argument of the planner: it plans, or is refused when it is made."""

from __future__ import annotations

from dataclasses import fields

import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.scenario.builder import build_planning_scenario
from tests.strange_values import STRANGE


@pytest.mark.parametrize("name", [each.name for each in fields(MotionPrimitivePlanner)])
def test_anything_is_planned_with_or_refused_when_it_is_made(name: str) -> None:
    scenario = build_planning_scenario(Boxes3D.empty())
    for value in STRANGE:
        try:
            planner = MotionPrimitivePlanner(**{name: value})
        except ConfigurationError as error:
            assert name in str(error)  # noqa: PT017 - the others plan
        else:
            planner.plan(scenario)
