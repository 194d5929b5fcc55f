"""Attacks of the Adversarial Robustness Toolbox (ART) as attacks of ours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from avsec_gym.argument_checks import keep_checked, label, number, shown
from avsec_gym.attacks.argument_domains import LEVELS
from avsec_gym.attacks.attack import Budget, Seed, Victim
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.suggestions import unknown_name

_NEEDED = {"SquareAttack": {"adv_criterion", "loss"}}
"""What ART would ask a classifier for."""


@dataclass(frozen=True, eq=False)
class ToolboxAttack:
    """An attack of ART on a stereo detector; see `StereoDetectorEstimator` for which can run.

    Args:
        method: A class of `art.attacks.evasion`, such as ``BasicIterativeMethod``.
        epsilon: The method's `eps`, grey levels; in any norm no channel of a pixel changes by more.
        arguments: The method's other arguments.
        name: Name of the attack in results; None: ``art`` and the method.

    Raises:
        ConfigurationError: ART is not installed, has no such attack, or one that has no such
            arguments, needs others or asks for a classifier.  Values are ART's to check, when it
            attacks.
    """

    method: str = "ProjectedGradientDescent"
    epsilon: float = 4.0
    arguments: Mapping[str, Any] = field(default_factory=dict)
    name: str | None = None

    def __post_init__(self) -> None:
        method = label("method", self.method)
        checked = {
            "method": method,
            "epsilon": number("epsilon", self.epsilon, *LEVELS),
            "name": f"art {method}" if self.name is None else label("name", self.name),
        }
        keep_checked(self, checked)
        if not isinstance(self.arguments, Mapping):
            raise ConfigurationError(
                'arguments takes a dictionary, such as {"max_iter": 7, "eps_step": 1.0}, got'
                f" {shown(self.arguments)}"
            )
        kind = self._kind()
        for name in self.arguments:
            if name not in _known(kind):
                problem = f"arguments: ART's {method} has no argument {shown(name)}"
                raise ConfigurationError(unknown_name(problem, str(name), _known(kind)))

    @property
    def budget(self) -> Budget:
        """Epsilon."""
        return Budget(self.epsilon)

    @property
    def needs_gradient(self) -> bool:
        """Whether the method climbs the gradient of the victim's loss."""
        from art.estimators import LossGradientsMixin

        return LossGradientsMixin in self._kind()._estimator_requirements

    def attack(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> SensorFrame:
        """The frame that ART makes; see `Attack.attack`.

        Raises:
            ConfigurationError: The method takes other arguments, or other victims.
        """
        from avsec_gym.attacks.art_estimator import (
            StereoDetectorEstimator,
            packed,
            targets,
            unpacked,
        )

        estimator = StereoDetectorEstimator(victim.detector, frame, victim.disparity)
        with _seeded(seed):
            attacked = self._made(estimator).generate(packed([frame]), targets([victim.truth]))
        return unpacked(attacked[0], frame)

    def _kind(self) -> Any:
        """ART's class."""
        try:
            # It guards ART's first import.
            from avsec_gym.attacks import art_estimator
        except ModuleNotFoundError as error:
            raise ConfigurationError(str(error)) from error
        from art.attacks import evasion

        kinds = {
            name: set(kind._estimator_requirements)
            for name, kind in vars(evasion).items()
            if hasattr(kind, "_estimator_requirements") and "eps" in kind.attack_params
        }
        ours = set(art_estimator.StereoDetectorEstimator.__mro__)
        can_run = [name for name, needed in kinds.items() if needed and needed <= ours]
        if self.method in kinds and self.method not in can_run:
            raise ConfigurationError(
                f"method: ART's {self.method} asks for more than a loss and its gradient, such as"
                f" classes.  These do not: {', '.join(can_run)}"
            )
        if self.method not in kinds:
            problem = f"method: ART has no attack {shown(self.method)} with a largest change `eps`"
            raise ConfigurationError(unknown_name(problem, self.method, can_run))
        if missing := _NEEDED.get(self.method, set()) - set(self.arguments):
            raise ConfigurationError(
                f"arguments: ART's {self.method} needs functions, {' and '.join(sorted(missing))},"
                " which no JSON can hold: make it in Python"
            )
        return getattr(evasion, self.method)

    def _made(self, estimator: Any) -> Any:
        kind = self._kind()
        quiet = {"verbose": False} if "verbose" in kind.attack_params else {}
        try:
            return kind(estimator, eps=self.epsilon, **(quiet | dict(self.arguments)))
        except (TypeError, ValueError) as error:
            raise ConfigurationError(f"ART's {self.method} cannot be made: {error}") from error


def _known(kind: Any) -> list[str]:
    """The arguments that are not given otherwise."""
    return sorted({*kind.attack_params} - {"eps", "verbose"})


@contextmanager
def _seeded(seed: Seed) -> Iterator[None]:
    """ART draws from NumPy's global generator, which others find afterwards as they left it."""
    before = np.random.get_state()  # noqa: NPY002
    np.random.seed(np.random.SeedSequence(seed).generate_state(4))  # noqa: NPY002
    try:
        yield
    finally:
        np.random.set_state(before)  # noqa: NPY002
