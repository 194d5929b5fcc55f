"""Perturbations stronger than the thesis': more steps, the class alone, and the mean over noise.

Chapter 5's perturbations have 4 steps and climb the whole loss.  A detector that keeps its
precision under them may still lose it to more steps, to an attack that spends all of its change on
classes, or to one whose gradient outlasts noise.  Without these, robustness is no finding (Tramer
et al., "On adaptive attacks to adversarial example defenses", NeurIPS 2020).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from avsec_gym.argument_checks import one_of, whole_number
from avsec_gym.attacks.argument_domains import STEPS
from avsec_gym.errors import ConfigurationError

if TYPE_CHECKING:  # What only names attacks needs no torch.
    from avsec_gym.attacks.attack import Seed, Victim
    from avsec_gym.attacks.perturbation import Perturbation
    from avsec_gym.experiments.chapter5.settings import Options
    from avsec_gym.frame import SensorFrame


@dataclass(frozen=True)
class StrongerAttack:
    """One of them; its number of steps is the strength of its results.

    Args:
        name: The attack in the setting of results.
        words: The name for readers.
        alpha: Length of a step, grey levels.
        epsilon: Bound of the whole change, onto which it is projected, grey levels; None: the
            thesis' form, whose change grows with the steps.
        class_only: Whether the class' terms of the loss are climbed alone.
        over_noise: Whether the gradient is the mean over noisy copies of the pair.
    """

    name: str
    words: str
    alpha: float
    epsilon: float | None = None
    class_only: bool = False
    over_noise: bool = False

    def perturbation(self, steps: int, options: Options) -> Perturbation:
        """The attack with a number of steps.

        Args:
            steps: The steps, n.
            options: Options of the attack, see `STRONGER_OPTIONS`.

        Raises:
            ConfigurationError: The number of copies or the noise cannot be.
        """
        from avsec_gym.attacks.expectation_over_noise import ExpectationOverNoise
        from avsec_gym.attacks.loss_terms import LossTerms
        from avsec_gym.attacks.perturbation import Perturbation

        bounded = self.epsilon is not None
        terms = LossTerms.CLASS_ONLY if self.class_only else LossTerms.ALL
        if not self.over_noise:
            return Perturbation(
                self.alpha, self.epsilon, steps, projected=bounded, name=self.name, terms=terms
            )
        return ExpectationOverNoise(
            self.alpha,
            self.epsilon,
            steps,
            projected=bounded,
            name=self.name,
            terms=terms,
            copies=options["eot_copies"],
            noise=options["eot_noise"],
        )


STRONGER = (
    StrongerAttack("long_pgd-0.4", "long thesis PGD α 0.4", 0.4),
    StrongerAttack("long_pgd-1", "long thesis PGD α 1", 1.0),
    StrongerAttack("bounded_pgd-4", "PGD within 4 grey levels", 1.0, 4.0),
    StrongerAttack("class_pgd-1", "class-only thesis PGD α 1", 1.0, class_only=True),
    StrongerAttack(
        "bounded_class_pgd-4", "class-only PGD within 4 grey levels", 1.0, 4.0, class_only=True
    ),
    StrongerAttack("eot_pgd-4", "PGD over noise within 4 grey levels", 1.0, 4.0, over_noise=True),
)
"""All of them, in the order of tables.  With 4 steps, ``long_pgd-...`` and ``bounded_pgd-4`` are
the thesis' attacks; what is within 4 grey levels has the budget of the thesis' alpha 1, n 4."""
STRONGER_NAMES = tuple(attack.name for attack in STRONGER)

ALL = "all"
STRONGER_OPTIONS: Options = {
    "stronger": "",
    "drawn_scenes": 150,
    "steps": [4, 20, 40],
    "eot_copies": 4,
    "eot_noise": 4.0,
}
"""``stronger``: names of `STRONGER` with commas, or ``all``; none: in a run of ``chapter5`` none of
them, in one of ``stronger_perturbations`` all.  ``drawn_scenes``: number of scenes that they are
measured on, see `drawn_scenes`; ``steps``: the numbers of steps that are looked at; ``eot_copies``,
``eot_noise``: noisy copies, and standard deviation of the noise in grey levels, of
``eot_pgd-...``."""


def chosen_attacks(options: Options) -> tuple[str, ...]:
    """The names that the options ask for, in the order of tables.

    Raises:
        ConfigurationError: There is no such attack.
    """
    asked = [name.strip() for name in options["stronger"].split(",") if name.strip()]
    for name in asked:
        one_of("stronger", name, (*STRONGER_NAMES, ALL))
    return tuple(name for name in STRONGER_NAMES if name in asked or ALL in asked)


def looked_at_steps(options: Options) -> tuple[int, ...]:
    """The numbers of steps that the options ask for, the least first.

    Raises:
        ConfigurationError: These are no numbers of steps.
    """
    steps = options["steps"]
    if not steps:
        raise ConfigurationError(
            "steps takes one number of steps or more, got []: for instance, give steps=[4,20]"
        )
    return tuple(sorted({whole_number("steps", each, 1, STEPS) for each in steps}))


def stronger_iterates(
    name: str, frame: SensorFrame, victim: Victim, options: Options, seed: Seed
) -> Iterator[tuple[int, SensorFrame]]:
    """The frame under one of `STRONGER` after each of the numbers of steps, with that number.

    The gradients are taken once: the frame after 20 steps goes on from that after 4.

    Args:
        name: The attack's name.
        frame: The clean frame.
        victim: The attacked car.
        options: Options of the attack, see `STRONGER_OPTIONS`.
        seed: Seed of the noise.

    Raises:
        ConfigurationError: The options cannot be, or the detector has no such loss.
    """
    wanted = looked_at_steps(options)
    (attack,) = (each for each in STRONGER if each.name == name)
    iterates = attack.perturbation(wanted[-1], options).iterates(frame, victim, seed)
    for n, attacked in enumerate(iterates, start=1):
        if n in wanted:
            yield n, attacked
