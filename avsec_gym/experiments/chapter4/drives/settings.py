"""Windows, states and options of the experiment on drives of connected vehicles."""

from __future__ import annotations

from avsec_gym.experiments.chapter4.settings import CLEAN, Part, State

WINDOW = 10
"""Successive instants of a window, a second of them."""
STATES: tuple[State, ...] = (CLEAN, "ghost", "removal")
TOLERANCE = 1.0
"""Metres by which an attacked object's box is grown: an alarm is about the attack where the centre
of its region lies in it."""
OPTIONS = {"constants": "", "windows": 1, "apart": WINDOW, "attacked": 300}
"""``constants``: a file that `avsec connected --fit` wrote; the package's own if empty.
``windows``: windows of each judged drive, which are alike.
``apart``: instants from the beginning of a window to that of the next; those of less than a window
overlap, and cost less.
``attacked``: the first so many drives to judge have a ghost and a removal in their first windows,
and as many drives to fit on are made, of one window each."""


def drive_setting(part: Part, state: State) -> str:
    """The setting of a run's rows."""
    return f"{part}, drives, {state}"
