"""Evidence of rays as a number: how much better a testimony fits to nothing than to an object."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats

_MOST_RAYS = 10_000


@dataclass(frozen=True)
class RayRates:
    """Chances of what a witness' rays do in the direction of a claimed voxel.

    The defaults are what `fit_rates` made of 30 instants of three vehicles of the procedural world
    (positions 0.2 m, headings 0.2 degrees, clocks up to 0.1 s apart).

    For rays that decide nothing about a voxel, as those that end in front of it, there is no
    chance.

    Args:
        support_present: The chance that they end in the region's box, where the claimed object is
            there.
        through_present: The chance that all pass through, where it is there.
        missing_present: The chance that none returns, where it is there.
        support_absent: The chance that they end in the region's box, where it is not there (or
            where the witness' scan was deprived of it).
        through_absent: The chance that all pass through, where it is not there.
        missing_absent: The chance that none returns, where it is not there.
        most: Number of independent rays that a testimony tends to: what errs, errs for all rays
            of an object at once.  With ``n`` rays it is ``n / (1 + (n - 1) / most)``, the
            effective size of a sample whose members correlate by ``1 / most`` (Kish, 1965).
        least: Number of rays that support or pass through below which a testimony decides nothing.
            Missing rays add to others; alone they may be due to what the witness cannot see, such
            as a dark car in front, and that would accuse it by all claims at once.

    Raises:
        ConfigurationError: A chance that is not between 0 and 1, or no positive number of rays.
    """

    support_present: float = 0.981
    through_present: float = 0.017
    missing_present: float = 0.002
    support_absent: float = 0.027
    through_absent: float = 0.850
    missing_absent: float = 0.123
    most: float = 2.0
    least: int = 5

    def __post_init__(self) -> None:
        chances = np.array(astuple(self)[:6])
        numbers = 0 < self.most <= 1e12 and 1 <= self.least <= _MOST_RAYS
        if not (((chances > 0) & (chances < 1)).all() and numbers):
            raise ConfigurationError(
                "chances of rays lie between 0 and 1, their numbers are positive, and"
                f" `least` is at most {_MOST_RAYS}; got {astuple(self)}"
            )

    @property
    def weights(self) -> Floats:
        """Log-likelihood ratio of a ray that supports, passes through, is missing, shape (3,)."""
        chances = np.log(astuple(self)[:6])
        return np.asarray(chances[3:] - chances[:3])


def log_likelihood_ratio(counts: ArrayLike, rates: RayRates) -> Floats:
    """How much more likely testimonies are of what is not there than of what is (natural log).

    With ``t`` rays through, ``s`` that support and ``m`` missing,
    ``t ln(t_absent / t_present) + s ln(s_absent / s_present) + m ln(m_absent / m_present)``, of
    scaled to the effective number of rays; 0 for testimonies that decide nothing.

    Args:
        counts: Counts as in `WitnessCounts`, shape (..., 3).
        rates: The chances of rays.

    Returns:
        Shape (...).
    """
    number = np.asarray(counts, np.float64)
    total = number.sum(axis=-1)
    design_effect = 1.0 + (np.maximum(total, 1.0) - 1.0) / rates.most
    return np.where(decidable(counts, rates), number @ rates.weights / design_effect, 0.0)


def decidable(counts: ArrayLike, rates: RayRates) -> NDArray[np.bool_]:
    """Whether testimonies count enough rays that returned to decide anything.

    Args:
        counts: Counts as in `WitnessCounts`, shape (..., 3).
        rates: The chances of rays.

    Returns:
        Shape (...).
    """
    return np.asarray(np.asarray(counts)[..., :2].sum(axis=-1) >= rates.least)
