"""The ends of what an attack's numbers can be, as users meet them: in attacks and their errors."""

from __future__ import annotations

import math
from typing import Any

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind, make

ENDS: list[tuple[Kind, dict[str, Any], str, float, float]] = [
    (Kind.ATTACK, {"name": "random_noise"}, "strength", 1e-6, 255.0),
    (Kind.ATTACK, {"name": "fgsm"}, "epsilon", 1e-6, 255.0),
    (Kind.ATTACK, {"name": "expectation_over_noise"}, "noise", 0.0, 255.0),
    (Kind.ATTACK, {"name": "expectation_over_noise"}, "copies", 1, 10_000),
    (Kind.ATTACK, {"name": "thesis_pgd"}, "steps", 1, 100_000),
    (Kind.ATTACK, {"name": "mi_fgsm"}, "momentum", 0.0, 100.0),
    (Kind.OPTICAL_ATTACK, {"name": "facula"}, "radius", 0.01, 1e6),
    (Kind.OPTICAL_ATTACK, {"name": "facula"}, "strength", 0.01, 1e5),
    (Kind.OPTICAL_ATTACK, {"name": "lidar_spoofing"}, "bearing", -4 * math.pi, 4 * math.pi),
    (Kind.OPTICAL_ATTACK, {"name": "lidar_spoofing"}, "distance", 0.01, 10_000.0),
    (Kind.OPTICAL_ATTACK, {"name": "lidar_spoofing"}, "width", 0.001, 1000.0),
]


@pytest.mark.parametrize(("kind", "part", "name", "least", "most"), ENDS)
def test_both_ends_are_taken_and_what_lies_beyond_is_not(
    kind: Kind, part: dict[str, Any], name: str, least: float, most: float
) -> None:
    step = 1 if isinstance(most, int) else 1e-9 * max(1.0, abs(most))
    for end, beyond in ((least, least - step), (most, most + step)):
        make(kind, {**part, name: end})
        with pytest.raises(ConfigurationError, match=name):
            make(kind, {**part, name: beyond})
