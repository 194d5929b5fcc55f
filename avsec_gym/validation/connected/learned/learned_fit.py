"""`LearnedFit`: the model of the learned comparison, its alarms, its card, and their file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.metrics.roc_curve import threshold_at
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_fields import fitting_fields
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.validation.connected.learned.features import FEATURES
from avsec_gym.validation.connected.learned.logistic_model import LogisticModel

KIND, FORMAT = "connected_learned", 1
SHIPPED_MODEL = Path(__file__).parents[1] / "fits" / "learned_64_beams.json"
"""Fitted by `fit_learned` on the procedural world; its card states on which places."""
_REMEDY = "Fit anew: `avsec connected --data DATA --method learned --fit FILE`."
_MOST_SAMPLES = 2_000_000


@dataclass(frozen=True)
class LearnedCard:
    """What a model was fitted on, and what it is worth on instants that it was not fitted on.

    Args:
        data: What names the instants: data set, seed, assets, how many; JSON-able.
        constants: What the log-likelihood ratios of its features were fitted on, in words.
        attacked: Number of attacked regions.
        attack_free: Number of attack-free regions.
        penalty: How much large weights cost, as of `fit_logistic`.
        folds: Number of parts of the instants, each of which is held out once.
        held_out_area: Area under the ROC curve over regions that were held out.
        held_out_loss: The mean logistic loss over those regions, nats.
    """

    data: Mapping[str, Any]
    constants: str
    attacked: int
    attack_free: int
    penalty: float
    folds: int
    held_out_area: float
    held_out_loss: float


@dataclass(frozen=True)
class LearnedRule:
    """What the base station decides by.

    Args:
        model: The model.
        threshold: Log odds above which a region alarms.
    """

    model: LogisticModel
    threshold: float


@dataclass(frozen=True)
class LearnedFit:
    """A model with what its alarms come from.

    Args:
        model: The model of all instants.
        clean_log_odds: The highest log odds of each attack-free instant, by a model that was
            fitted without it, rising; -inf where nothing was compared.
        card: What it was fitted on.

    Raises:
        ConfigurationError: A model of other features than `FEATURES`, or no log odds.
    """

    model: LogisticModel
    clean_log_odds: tuple[float, ...]
    card: LearnedCard

    def __post_init__(self) -> None:
        if len(self.model.weights) != len(FEATURES) or not self.clean_log_odds:
            raise ConfigurationError(
                f"a learned comparison has a weight for each of {len(FEATURES)} features, and log"
                " odds of attack-free instants"
            )

    def rule(self, alarms: float = 0.1) -> LearnedRule:
        """What is decided by where a share of attack-free instants may alarm.

        Raises:
            ConfigurationError: A share that is none.
        """
        if not 0 <= alarms < 1:
            raise ConfigurationError(f"the share of false alarms is from 0 to 1, got {alarms}")
        return LearnedRule(self.model, threshold_at(np.array(self.clean_log_odds), alarms))

    @property
    def origin(self) -> str:
        """What it was fitted on, in words."""
        card = self.card
        return (
            f"learned on {card.attacked} attacked and {card.attack_free} attack-free regions of"
            f" {len(self.clean_log_odds)} instants"
        )


def write_learned_fit(path: str | Path, fit: LearnedFit, *, overwrite: bool = False) -> None:
    """Write it as JSON with its card, whole or not at all.

    Raises:
        DataError: The file exists and `overwrite` is false, or it cannot be written.
    """
    content = {
        "format": FORMAT,
        "kind": KIND,
        "features": list(FEATURES),
        "model": asdict(fit.model),
        # JSON knows no infinity.
        "clean_log_odds": [each if np.isfinite(each) else None for each in fit.clean_log_odds],
        "card": asdict(fit.card),
    }
    text = json.dumps(content, indent=1, allow_nan=False) + "\n"
    write_bytes(path, text.encode(), overwrite=overwrite)


def read_learned_fit(path: str | Path) -> LearnedFit:
    """Read what `write_learned_fit` wrote.

    Raises:
        DataError: Missing, damaged, of another kind or format, or of other features.
    """
    content = read_json_object(path, remedy=_REMEDY)
    try:
        given = (content["kind"], content["format"], content["features"])
        if given != (KIND, FORMAT, list(FEATURES)):
            raise ValueError(f"it is no {KIND!r} in format {FORMAT} of this version's features")
        model, odds = content["model"], content["clean_log_odds"]
        if not isinstance(odds, list) or len(odds) > _MOST_SAMPLES:
            raise ValueError(f"log odds are a list of {_MOST_SAMPLES} at most")
        return LearnedFit(
            LogisticModel(
                _numbers(model["centre"]),
                _numbers(model["scale"]),
                _numbers(model["weights"]),
                _number(model["offset"]),
            ),
            tuple(-np.inf if each is None else _number(each) for each in odds),
            LearnedCard(**fitting_fields(LearnedCard, content["card"])),
        )
    except (KeyError, TypeError, ValueError, ConfigurationError) as error:
        what = f"lacks {error}" if isinstance(error, KeyError) else f"is damaged: {error}"
        raise DataError(f"The file {what}.", path=path, remedy=_REMEDY) from error


def _numbers(values: list[object]) -> tuple[float, ...]:
    return tuple(_number(each) for each in values)


def _number(value: object) -> float:
    """A finite number of JSON.

    Raises:
        ValueError: It is none.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
        raise ValueError(f"{value!r} is no number")
    return float(value)
