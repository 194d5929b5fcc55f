"""The section of perturbations that are stronger than the thesis'."""

from __future__ import annotations

from dataclasses import replace

from avsec_gym.experiments.chapter5.section.tables_beyond import loss_table
from avsec_gym.experiments.chapter5.stronger_rows import StrongerRows
from avsec_gym.runs.section import Section

TITLE = "What stronger perturbations take"


def stronger_section(found: StrongerRows) -> Section:
    """Their losses, against the unattacked detectors on the drawn scenes.

    Args:
        found: The losses.
    """
    table = replace(loss_table(found.attacks), title=TITLE)
    return Section(
        "stronger",
        TITLE,
        parts=[table],
        link="Stronger",
        context=f"On {found.scenarios:,} scenes that were drawn by the run's seed; n: steps. “Long”"
        " goes on from the thesis' last step without a bound, so that its change grows with n; what"
        " is within 4 grey levels changes no pixel by more than the thesis' α 1, n 4. “Class-only”"
        " climbs the loss' terms of classes alone; “over noise” follows the mean gradient of noisy"
        " copies of the pair.",
        text_tables=[table],
    )
