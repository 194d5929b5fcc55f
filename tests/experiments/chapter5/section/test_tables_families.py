"""Tables of families and of contested scenes hold the figures, and dashes where there are none."""

from __future__ import annotations

import numpy as np

from avsec_gym.drawing.page_table import UNKNOWN
from avsec_gym.experiments.chapter5.contested_scenes import ContestedFigures, ContestedRates
from avsec_gym.experiments.chapter5.decoupling import AttackRow, Decoupling
from avsec_gym.experiments.chapter5.families import FamilyFigures, figures_of
from avsec_gym.experiments.chapter5.losses import Losses
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.section.tables_families import (
    compared_table,
    contested_family_table,
    contested_loss_table,
    contested_rate_table,
    family_table,
)
from avsec_gym.metrics.cluster_bootstrap import Sampled
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.safety import COLLISION, SAFE, SafetyRates, SafetyRecord

CLEAN = Condition("dsgn")


def found(rate: float = 0.25, patches: int = 3) -> FamilyFigures:
    """Perturbations at a tenth of a point of safety for a point, patches at another rate."""
    names = [("thesis_pgd-1", float(n)) for n in (1, 2, 3)]
    names += [("patch-random", 0.0), ("patch-specific", 0.0), ("joint-random", 0.0)][:patches]
    random = np.random.default_rng(0)

    def sampled(value: float) -> Sampled:
        return Sampled(value, value + 0.1 * random.normal(size=500))

    return figures_of(
        [
            Losses(
                Condition("dsgn", *name),
                sampled(10.0 * (number % 3 + 1)),
                sampled(10.0 * (number % 3 + 1) * (0.1 if number < 3 else rate)),
            )
            for number, name in enumerate(names)
        ]
    )


def test_a_line_for_each_family() -> None:
    table = family_table(found())
    lines = {line[1].text: [cell.text for cell in line[2:]] for line in table.rows}
    assert list(lines) == ["all", "perturbations", "patches"]
    assert lines["perturbations"] == ["3", "1.00", "20.0", "2.0", "0.10", "3", "0", "0"]
    assert lines["patches"][4] == "0.25"
    assert all(line[6].interval for line in table.rows)


def test_rates_against_each_other() -> None:
    (line,) = compared_table(found().compared).rows
    assert [cell.text for cell in line[:6]] == [
        "DSGN", "patches", "perturbations", "2.50", "+0.15", "< 0.001",
    ]  # fmt: skip
    few = compared_table(found(patches=0).compared)
    assert few.rows == []


def test_contested_figures_stand_beside_all() -> None:
    table = contested_family_table(found(), found(rate=0.5, patches=2))
    lines = {line[1].text: [cell.text for cell in line[2:]] for line in table.rows}
    assert lines["patches"] == ["3", "1.00", UNKNOWN, "0.25", "0.50"]
    absent = contested_family_table(found(), found(patches=0))
    assert [cell.text for cell in absent.rows[2][4:]] == [UNKNOWN, "0.25", UNKNOWN]

    attack, rounded = (
        Condition("dsgn", "thesis_pgd-1", 1.0),
        Condition("dsgn", "noise-1", 4.0, True),
    )

    def row(condition: Condition, precision: float, safety: float) -> AttackRow:
        return AttackRow(condition, Estimate(precision), Estimate(safety), True, None)

    other = Condition("dsgn", "patch-random")
    losses = contested_loss_table(
        [row(attack, 10.0, 1.0), row(other, 5.0, 2.0), row(rounded, 1.0, 1.0)],
        [row(attack, 12.0, 30.0)],
    )
    assert [[cell.text for cell in line[2:]] for line in losses.rows] == [
        ["10.0", "12.0", "1.0", "30.0"],
        ["5.0", UNKNOWN, "2.0", UNKNOWN],
    ]


def test_rates_of_contested_episodes() -> None:
    def rates(*outcomes: str) -> SafetyRates:
        return SafetyRates.of(
            [SafetyRecord(str(n), "left", o, 1.5, 1, 9.0, 1.5) for n, o in enumerate(outcomes)],
        )

    rows = [
        ContestedRates(CLEAN, False, rates(SAFE, SAFE, SAFE, COLLISION)),
        ContestedRates(CLEAN, True, rates(SAFE, COLLISION)),
    ]
    nothing = Decoupling(2, [], [], {}, {})
    table = contested_rate_table(ContestedFigures(1, 2, rows, nothing, FamilyFigures([], [])))
    (line,) = table.rows
    assert [cell.text for cell in line] == [
        "DSGN", "unattacked", "100.0", "25.0", "75.0", "100.0", "50.0", "50.0",
    ]  # fmt: skip
    assert all(cell.interval for cell in line[2:])
    assert "2 episodes of 1 scenes" in table.note
