"""The table of docs/environments.md: how often attackers of `avsec/GhostObject-v1` win."""

from __future__ import annotations

from avsec_gym.report.markdown_table import UNKNOWN, markdown_table, share
from studies.result_fields import bounds_at, field, number_at

_PLACE = field("ghost_attacker", "v1")
_SCENES = {"layouts": "held-out layouts", "safety_scenarios": "labelled scenarios"}
_ATTACKERS: dict[str, tuple[str, ...]] = {
    "a place at random": ("random",),
    "the best constant": ("rules", "constant"),
    "the best constant for each intention": ("rules", "constant_by_intention"),
    "the nearest place": ("rules", "nearest"),
    "the place nearest to the goal": ("rules", "nearest_to_goal"),
    "the place nearest to a point, searched": ("rules", "point"),
    "the same, a point for each intention": ("rules", "point_by_intention"),
    "the place with the most room": ("rules", "most_room"),
    "a score for each spot, fitted": ("spot_table",),
    "PPO": ("ppo",),
    "all places tried": ("oracle",),
}


def ghost_places_table() -> list[str]:
    """Lines of the table: success in percent, with 95 % intervals."""
    rows = [
        [name, *(_rate(scenes, steps) for scenes in _SCENES)] for name, steps in _ATTACKERS.items()
    ]
    rows.append(["PPO less the fitted score, paired", *map(_above, _SCENES)])
    return markdown_table(["attacker", *_SCENES.values()], rows)


def _above(scenes: str) -> str:
    """Points of a hundred."""
    place = _PLACE.then(scenes, "ppo_above_spot_table")
    bounds = bounds_at(place.then("interval"))
    if bounds is None:
        return UNKNOWN
    low, high = (share(bound) for bound in bounds)
    return f"{share(number_at(place.then('difference')))} ({low} to {high})"


def _rate(scenes: str, steps: tuple[str, ...]) -> str:
    place = _PLACE.then(scenes, *steps)
    bounds = bounds_at(place.then("interval"))
    if bounds is None:
        return UNKNOWN
    low, high = (share(bound) for bound in bounds)
    return f"{share(number_at(place.then('success_rate')))} % ({low}–{high})"
