"""How long each step takes, at one vehicle and at the base station."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from avsec_gym.experiments.chapter4.compared_instant import ComparedInstant
from avsec_gym.experiments.chapter4.settings import METHODS
from avsec_gym.validation.connected.validator import Method

StepPlace = Literal["vehicle", "base station"]
STEPS: Mapping[Method, Mapping[str, StepPlace]] = {
    "surfaces": {
        "propose": "vehicle",
        "merge": "base station",
        "crop": "vehicle",
        "compare": "base station",
        "decide": "base station",
    },
    "rays": {
        "propose": "vehicle",
        "merge": "base station",
        "claim": "vehicle",
        "witness": "vehicle",
        "decide": "base station",
    },
    "learned": {
        "propose": "vehicle",
        "merge": "base station",
        "claim": "vehicle",
        "witness": "vehicle",
        "crop": "vehicle",
        "compare": "base station",
        "decide": "base station",
    },
}
"""The steps of each method as `Traffic.step` names them, and who does them."""


@dataclass(frozen=True)
class StepTime:
    """How long a step takes at an instant.

    Args:
        method: The method.
        where: Who does it.
        step: The step.
        seconds: Mean CPU time, of one vehicle where vehicles do it.
        instants: Number of instants.
    """

    method: Method
    where: StepPlace
    step: str
    seconds: float
    instants: int


def seconds_of_steps(compared: ComparedInstant, vehicles: int) -> dict[str, float]:
    """The steps of an instant, as parts of a cell's time.

    Args:
        compared: The instant by all methods.
        vehicles: Number of vehicles, of which each step of vehicles has the mean.
    """
    return {
        _part(method, step): compared.results[method].seconds.get(step, 0.0)
        / (vehicles if where == "vehicle" else 1)
        for method in METHODS
        for step, where in STEPS[method].items()
    }


def step_times(timings: Mapping[str, Mapping[str, float]]) -> list[StepTime]:
    """The steps that a run measured.

    Args:
        timings: The ``cells`` and ``seconds`` of each part.
    """
    return [
        StepTime(method, where, step, part["seconds"] / part["cells"], int(part["cells"]))
        for method in METHODS
        for step, where in STEPS[method].items()
        if (part := timings.get(_part(method, step)))
    ]


def _part(method: Method, step: str) -> str:
    return f"{method}: {step}, CPU"
