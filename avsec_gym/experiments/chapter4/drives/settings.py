"""Windows, methods and options of the experiment on drives of connected vehicles."""

from __future__ import annotations

from avsec_gym.experiments.chapter4.settings import CLEAN, FITTED, JUDGED, Part, State
from avsec_gym.validation.connected.validator import Method

WINDOW = 10
"""Successive instants of a window, a second of them."""
DRIVE_METHODS: tuple[Method, ...] = ("rays", "learned")
"""Those whose scores are log odds, which add up."""
GHOST: State = "ghost"
DRIVE_STATES: dict[Part, tuple[State, ...]] = {FITTED: (CLEAN,), JUDGED: (CLEAN, GHOST)}
OPTIONS = {"constants": "", "model": "", "windows": 1}
"""``constants``, ``model``: as in `avsec_gym.experiments.chapter4.settings`. ``windows``: windows
of each drive; more of them are cheaper than more drives, but are alike."""


def drive_setting(part: Part, state: State) -> str:
    """The setting of a run's rows."""
    return f"{part}, drives, {state}"
