"""Actions as agents hand them in: checked before anything believes them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError


def checked_action(action: Any, size: int) -> NDArray[np.float64]:
    """A copy with values cut to [-1, 1], shape (size,).

    Raises:
        ConfigurationError: Another shape, or a value that is not finite.
    """
    try:
        array = np.array(action, float)
    except (TypeError, ValueError) as error:
        raise ConfigurationError(f"an action is an array of numbers, got {action!r}") from error
    if array.shape != (size,) or not np.isfinite(array).all():
        raise ConfigurationError(
            f"an action has shape {(size,)} and finite values, got shape {array.shape}: {action!r}"
        )
    return np.maximum(np.minimum(array, 1.0), -1.0)
