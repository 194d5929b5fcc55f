"""What stronger perturbations take, on the drawn scenes alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.decoupling import AttackRow, attack_row
from avsec_gym.experiments.chapter5.losses import losses
from avsec_gym.experiments.chapter5.outcomes import Outcomes
from avsec_gym.experiments.chapter5.scene_draw import drawn_scenes
from avsec_gym.experiments.chapter5.settings import UNATTACKED
from avsec_gym.experiments.chapter5.stronger_attacks import STRONGER_NAMES, STRONGER_OPTIONS
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results


@dataclass(frozen=True)
class StrongerRows:
    """The losses under `STRONGER` attacks.

    Args:
        scenarios: Number of drawn scenes that every attack was done for.
        attacks: A row for each detector, attack and number of steps, against the unattacked
            detector on the same scenes.
    """

    scenarios: int
    attacks: Sequence[AttackRow]


def stronger_rows(
    results: Results, configuration: Configuration, labels: Mapping[str, Boxes3D]
) -> StrongerRows | None:
    """The losses of a run's stronger attacks; None: it has none of them.

    Args:
        results: The results of the run.
        configuration: The run's configuration, whose seed drew the scenes.
        labels: The labels of each scenario of the run.
    """
    options = {**STRONGER_OPTIONS, **configuration.options}
    drawn = drawn_scenes(tuple(labels), options["drawn_scenes"], configuration.seed)
    outcomes = Outcomes(
        results,
        {scenario: labels[scenario] for scenario in drawn},
        attacks=(UNATTACKED, *STRONGER_NAMES),
    )
    rows = (
        [attack_row(outcomes, attack) for attack in losses(outcomes)] if outcomes.scenarios else []
    )
    return StrongerRows(len(outcomes.scenarios), rows) if rows else None
