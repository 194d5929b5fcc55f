"""Stronger perturbations: how they contain the thesis' ones, and what is filed of them."""

from __future__ import annotations

from collections.abc import Sequence
from types import ModuleType

import numpy as np
import pytest
import torch
from torch import Tensor

from avsec_gym.attacks.attack import Victim
from avsec_gym.attacks.expectation_over_noise import ExpectationOverNoise
from avsec_gym.attacks.loss_terms import LossTerms
from avsec_gym.attacks.perturbation import thesis_pgd
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.attack_names import attack_name
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.scene_draw import drawn_scenes
from avsec_gym.experiments.chapter5.section.stronger_section import stronger_section
from avsec_gym.experiments.chapter5.settings import ATTACKS
from avsec_gym.experiments.chapter5.stronger_attacks import (
    STRONGER,
    STRONGER_NAMES,
    STRONGER_OPTIONS,
    stronger_iterates,
)
from avsec_gym.experiments.chapter5.stronger_rows import StrongerRows, stronger_rows
from avsec_gym.experiments.json_rows import row_json
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.perception.stereo_batch import StereoBatch
from avsec_gym.runs.experiment import Configuration
from tests.finds_nothing import FindsNothing


class Bends(FindsNothing):
    """A loss with a class and boxes whose gradients change their signs on the way."""

    name = "bends"

    def __init__(self) -> None:
        random = np.random.default_rng(5)
        self.targets = torch.from_numpy(random.uniform(90, 160, (2, 2, 3, 6, 10)))
        self.gradients = 0

    def losses(
        self, batch: StereoBatch, truth: Sequence[Boxes3D], disparity: Tensor | None = None
    ) -> dict[str, Tensor]:
        self.gradients += 1
        pixels = torch.stack([batch.left, batch.right], dim=1).double()
        of_class, of_boxes = (-((pixels - target) ** 2).sum() for target in self.targets)
        return {"class": of_class, "box": of_boxes}


def frame() -> SensorFrame:
    projection = np.array([[120.0, 0, 5, 0], [0, 120, 3, 0], [0, 0, 1, 0]])
    right = projection - [[0, 0, 0, 65.0], [0] * 4, [0] * 4]
    calibration = Calibration([projection] * 3 + [right], np.eye(3), np.eye(4)[:3])
    images = np.random.default_rng(1).integers(60, 196, (2, 6, 10, 3), np.uint8)
    return SensorFrame("0", calibration, {2: images[0], 3: images[1]})


def pixels(of: SensorFrame) -> np.ndarray:
    return np.stack([of.image(2), of.image(3)]).astype(float)


@pytest.mark.parametrize("name", STRONGER_NAMES)
def test_each_number_of_steps_is_looked_at_on_the_way(name: str) -> None:
    detector = Bends()
    found = list(stronger_iterates(name, frame(), Victim(detector, Boxes3D.empty()),
                                   {**STRONGER_OPTIONS, "steps": [40, 4, 20]}, (0, 1)))  # fmt: skip
    assert [n for n, _ in found] == [4, 20, 40]
    copies = 4 if name.startswith("eot") else 1
    assert detector.gradients == 40 * copies  # Those of 4 and 20 steps are among them.


@pytest.mark.parametrize("attack", STRONGER, ids=lambda attack: attack.name)
def test_twenty_steps_hold_the_budget_of_four(attack: object) -> None:
    """What four steps can reach lies within what twenty can, and that within what forty can."""
    few, more, most = (attack.perturbation(n, STRONGER_OPTIONS).budget for n in (4, 20, 40))
    assert few.change <= more.change <= most.change
    victim, clean = Victim(Bends(), Boxes3D.empty()), frame()
    for n, attacked in stronger_iterates(attack.name, clean, victim, STRONGER_OPTIONS, 0):
        assert not attack.perturbation(n, STRONGER_OPTIONS).budget.exceeded_by(clean, attacked)
        if attack.epsilon is not None:
            assert attack.perturbation(n, STRONGER_OPTIONS).budget.change == attack.epsilon == 4
    if attack.epsilon is None:
        assert most.change == pytest.approx(10 * few.change)


@pytest.mark.parametrize(
    ("name", "alpha", "terms"),
    [
        ("long_pgd-0.4", 0.4, LossTerms.ALL),
        ("long_pgd-1", 1.0, LossTerms.ALL),
        ("bounded_pgd-4", 1.0, LossTerms.ALL),
        ("class_pgd-1", 1.0, LossTerms.CLASS_ONLY),
        ("bounded_class_pgd-4", 1.0, LossTerms.CLASS_ONLY),
    ],
)
def test_after_four_steps_it_is_the_thesis_attack(
    name: str, alpha: float, terms: LossTerms
) -> None:
    victim = Victim(Bends(), Boxes3D.empty())
    (_, attacked), *_ = stronger_iterates(name, frame(), victim, STRONGER_OPTIONS, 0)
    expected = thesis_pgd(alpha, 4, terms=terms).attack(frame(), victim)
    np.testing.assert_array_equal(pixels(attacked), pixels(expected))


def test_more_steps_within_the_same_ball_climb_higher() -> None:
    detector = Bends()
    victim = Victim(detector, Boxes3D.empty())
    heights = []
    for _, attacked in stronger_iterates(
        "bounded_pgd-4", frame(), victim, {**STRONGER_OPTIONS, "steps": [1, 4, 20]}, 0
    ):
        views = torch.from_numpy(pixels(attacked)).permute(0, 3, 1, 2)[None]
        heights.append(sum(-float(((views - target) ** 2).sum()) for target in detector.targets))
    assert heights[0] < heights[1] <= heights[2]


def test_the_options_reach_the_noise() -> None:
    (attack,) = (attack for attack in STRONGER if attack.over_noise)
    options = {**STRONGER_OPTIONS, "eot_copies": 7, "eot_noise": 2.5}
    assert attack.perturbation(20, options) == ExpectationOverNoise(
        1.0, 4.0, 20, projected=True, name="eot_pgd-4", copies=7, noise=2.5
    )


def test_names_are_their_own() -> None:
    names = [attack_name(name) for name in ATTACKS + STRONGER_NAMES]
    assert len(set(names)) == len(names)
    assert attack_name("bounded_class_pgd-4", 20) == "class-only PGD within 4 grey levels, n 20"


def test_losses_are_those_of_the_drawn_scenes_alone(made: ModuleType) -> None:
    results, names = made.MadeResults(), made.names(20)
    drawn = drawn_scenes(names, 8, seed=3)
    others = [name for name in names if name not in drawn]
    results.add(Condition("dsgn"), names, unsafe=others)
    results.add(Condition("dsgn", "thesis_pgd-1", 4.0), names, unsafe=names, lost=names)
    strong = Condition("dsgn", "bounded_class_pgd-4", 20.0)
    results.add(strong, drawn, unsafe=drawn[:2], lost=drawn)
    labels = {name: made.car() for name in names}
    configuration = Configuration(seed=3, options={"drawn_scenes": 8})
    found = stronger_rows(results, configuration, labels)
    assert found is not None
    assert found.scenarios == 8
    (row,) = found.attacks
    assert row.condition == strong
    assert row.safety_lost.value == pytest.approx(25.0)  # 2 of 8, none of them lost before.
    assert row.precision_lost.value > 0  # All that there was: no car is seen any more.
    assert row.paired is not None
    assert (row.paired.became_unsafe, row.paired.episodes) == (6, 24)
    # The chapter's own comparison does not know them.
    assert strong not in made.outcomes(results, names).conditions
    section = stronger_section(found)
    assert "On 8 scenes" in section.context
    assert section.tables[0].rows[0][1].text == "class-only PGD within 4 grey levels, n 20"
    assert row_json(StrongerRows(8, [row]))["scenarios"] == 8


def test_a_run_without_them_has_no_rows(made: ModuleType) -> None:
    results, names = made.MadeResults(), made.names(5)
    results.add(Condition("dsgn"), names)
    results.add(Condition("dsgn", "thesis_pgd-1", 4.0), names)
    assert stronger_rows(results, Configuration(), {name: made.car() for name in names}) is None
