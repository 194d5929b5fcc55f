"""Actions as agents hand them in, checked before they are used, and what they scale to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats


def checked_action(action: Any, size: int) -> Floats:
    """A copy with values cut to [-1, 1], shape (size,).

    Raises:
        ConfigurationError: Another shape, or a value that is not finite.
    """
    array = _finite(action, size)
    return np.maximum(np.minimum(array, 1.0), -1.0)


def checked_flags(action: Any, size: int) -> NDArray[np.bool_]:
    """An action of a `MultiBinary` space, shape (size,).

    Raises:
        ConfigurationError: Another shape, or a value that is neither 0 nor 1.
    """
    array = _finite(action, size)
    if not np.isin(array, (0, 1)).all():
        raise ConfigurationError(f"an action of flags has values 0 and 1, got {action!r}")
    return array.astype(bool)


@dataclass(frozen=True, eq=False)
class LinearScale:
    """A linear scale from [-1, 1] to values in their units, and back.

    Args:
        low: The values that -1 stands for, shape (N,).
        high: The values that 1 stands for, shape (N,).

    Example:
        >>> LinearScale([0.0, 10.0], [1.0, 20.0]).decode([-1.0, 0.0])
        array([ 0., 15.])
    """

    low: Floats
    high: Floats

    def __post_init__(self) -> None:
        for name in ("low", "high"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), float))

    def decode(self, action: Floats) -> Floats:
        """Values in their units, shape (N,)."""
        return self.low + 0.5 * (np.asarray(action, float) + 1.0) * (self.high - self.low)

    def encode(self, values: Floats) -> Floats:
        """The inverse of `decode`, shape (N,)."""
        return np.asarray(2.0 * (np.asarray(values) - self.low) / (self.high - self.low) - 1.0)


def _finite(action: Any, size: int) -> Floats:
    try:
        array = np.array(action, float)
    except (TypeError, ValueError) as error:
        raise ConfigurationError(f"an action is an array of numbers, got {action!r}") from error
    if array.shape != (size,) or not np.isfinite(array).all():
        raise ConfigurationError(
            f"an action has shape {(size,)} and finite values, got shape {array.shape}: {action!r}"
        )
    return array
