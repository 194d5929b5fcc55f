"""The validators of connected vehicles that have names, and what a plug-in's is asked."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number, place
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.fit import SHIPPED_FIT, ConnectedFit, read_connected_fit
from avsec_gym.validation.connected.learned.learned_fit import SHIPPED_MODEL, read_learned_fit
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan


class JudgedRegions(Protocol):
    """What a validator of several vehicles makes of an instant, R regions.

    `ConnectedResult` is one.
    """

    @property
    def regions(self) -> Regions:
        """Where it looked, world frame."""
        ...

    @property
    def score(self) -> Floats:
        """How much speaks for an attack, shape (R,); -inf where nothing was compared."""
        ...

    @property
    def named(self) -> NDArray[np.int64]:
        """The victim by its number, `CANNOT_TELL` or `NO_ATTACK`, shape (R,).

        Both are numbers of `avsec_gym.validation.connected.rays.decision`, -1 and -2.
        """
        ...


@runtime_checkable
class InstantValidator(Protocol):
    """Anything that finds out which of several vehicles is lied to by its LiDAR."""

    def validate(self, scans: Sequence[VehicleScan], *, id: str = "") -> JudgedRegions:
        """Judge an instant.

        Args:
            scans: The scan of each vehicle with the pose that it measured, by number.
            id: Name of the instant.
        """
        ...


def rays_validator(
    *, constants: str | Path | None = None, alarms: float = 0.1
) -> ConnectedValidator:
    """Vehicles compare where their rays end, and what they pass through.

    Args:
        constants: A file of `avsec connected --fit`; None: the package's own.
        alarms: Share of attack-free instants that may alarm.

    Raises:
        ConfigurationError: No such share, or no name of a file.
        DataError: The file is missing or damaged.
    """
    fit = fit_in(constants)
    return ConnectedValidator(fit.constants(alarms=number("alarms", alarms, 0.0, 1.0)), "rays")


def surfaces_validator(
    *, constants: str | Path | None = None, rate: float = 0.1
) -> ConnectedValidator:
    """The thesis' method: the base station compares the surfaces of mirrored crops.

    Args:
        constants: A file of `avsec connected --fit`; None: the package's own.
        rate: Designated false positive rate r of distances.

    Raises:
        ConfigurationError: No such share, or no name of a file.
        DataError: The file is missing or damaged.
    """
    fit = fit_in(constants)
    return ConnectedValidator(fit.constants(rate=number("rate", rate, 0.0, 1.0)), "surfaces")


def learned_validator(
    *, constants: str | Path | None = None, model: str | Path | None = None, alarms: float = 0.1
) -> ConnectedValidator:
    """A small model weighs what rays and surfaces state of each region (thesis, section 6.2).

    Args:
        constants: A file of `avsec connected --fit`; None: the package's own.
        model: A file of `avsec connected --method learned --fit`; None: the package's own.
        alarms: Share of attack-free instants that may alarm.

    Raises:
        ConfigurationError: No such share, or no name of a file.
        DataError: A file is missing or damaged.
    """
    alarms = number("alarms", alarms, 0.0, 1.0)
    learned = read_learned_fit(SHIPPED_MODEL if model is None else place("model", model))
    fit = fit_in(constants)
    return ConnectedValidator(fit.constants(alarms), "learned", learned=learned.rule(alarms))


def fit_in(constants: str | Path | None) -> ConnectedFit:
    """The constants in a file; None: the package's own."""
    return read_connected_fit(SHIPPED_FIT if constants is None else place("constants", constants))
