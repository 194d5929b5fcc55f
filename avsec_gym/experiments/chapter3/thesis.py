"""Figures of the thesis' chapter 3, to stand beside ours; rates as fractions."""

from __future__ import annotations

from typing import NamedTuple

from avsec_gym.experiments.chapter3.settings import RATES, SCENARIOS
from avsec_gym.sensor_system import Triple

DETECTION = {
    (scenario, rate): percent / 100
    for scenario, row in zip(
        SCENARIOS,
        ((99.46, 99.89, 99.89, 99.91, 99.91), (99.94, 99.97, 100.0, 100.0, 100.0)),
        strict=True,
    )
    for rate, percent in zip(RATES, row, strict=True)
}
"""Average detection rate by scenario and r (table 3.1)."""


class ErrorBounds(NamedTuple):
    """Where the thesis finds E."""

    clean_below: float
    clean: str
    """How many clean frames, in its words."""
    attacked_above: float
    attacked: str


ERROR_BOUNDS: dict[Triple, ErrorBounds] = {
    SCENARIOS["LiDAR and two cameras"]: ErrorBounds(0.20, "most", 0.25, "most"),
    SCENARIOS["three cameras"]: ErrorBounds(0.10, "virtually all", 0.125, "99 %"),
    (0, 1, 3): ErrorBounds(0.23, "most", 0.23, "all"),
}
"""Error bounds by triple (figures 3.5, 3.7 and 3.9)."""

OBJECT_LEVEL = {
    (scenario, iou): percent / 100
    for scenario, row in zip(SCENARIOS, ((65.32, 59.54), (67.17, 63.39)), strict=True)
    for iou, percent in zip((0.5, 0.7), row, strict=True)
}
"""Average detection rate of the object-level baseline by scenario and IoU (table 3.1)."""

IDENTIFICATION = {
    rate: tuple(percent / 100 for percent in row)
    for rate, row in zip(
        RATES,
        (
            (99.80, 96.40, 93.40, 95.60, 96.30),
            (98.80, 97.00, 97.60, 99.20, 98.15),
            (98.00, 96.80, 97.20, 99.20, 97.80),
            (96.60, 96.00, 96.20, 99.80, 97.15),
            (94.80, 94.00, 94.20, 100.0, 95.75),
        ),
        strict=True,
    )
}
"""Identification rate by r: S_0 to S_3 attacked alone, and their mean (table 3.2)."""
