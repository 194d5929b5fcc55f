"""`ErrorModel`: the errors of one detector under one attack, as distributions.

    miss      logistic in distance, hidden share, share outside the image, and category
    place     along and across the line of sight: Student's t, its scale grows with the distance
    heading   Student's t; turned round with a probability
    size      Student's t of the logarithms of length and width
    ghosts    so many in a frame, at places where the detector was seen to put them

Misses and errors of one object are remembered from frame to frame, by Gaussian copulas whose
correlation decays with time.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import expit, stdtr, stdtrit

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.error_model.object_views import ObjectViews
from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_files import read_json_object

FORMAT = 1
TERMS = ("constant", "distance", "distance_squared", "hidden", "outside", "not_car")
"""What the log-odds of a detection depend on; distances in units of 20 m."""
COMPONENTS = ("radial", "lateral", "turn", "log_length", "log_width")
"""What a detection has wrong, metres and radians."""
UNIT = 20.0
FARTHEST = 60.0
"""Metres.  Objects beyond concern no planner, and models are fitted to none: they are taken as if
they were as near as this, since a growth that goes on would put them anywhere."""
_LARGEST = 1e3
"""The largest coordinate of a ghost's place, metres, and of its heading."""
_FEWEST = 0.1
"""Degrees of freedom; with fewer, errors are beyond all numbers."""
_REMEDY = "Fit it anew with `avsec error-model fit`."


@dataclass(frozen=True)
class Spread:
    """A Student's t distribution whose scale grows with the distance.

    Args:
        bias: Location, metres or radians.
        scale: Scale at no distance, positive.
        growth: Growth of the scale's logarithm over 20 m.
        freedom: Degrees of freedom: the fewer, the heavier the tails.
    """

    bias: float = 0.0
    scale: float = 1e-6
    growth: float = 0.0
    freedom: float = 30.0

    def scales(self, distance: Floats) -> Floats:
        """The scale at each distance, metres, shape (N,)."""
        return np.asarray(self.scale * np.exp(self.growth * np.minimum(distance, FARTHEST) / UNIT))

    def quantiles(self, shares: Floats, distance: Floats) -> Floats:
        """The errors below which such shares of all lie, shape (N,)."""
        return np.asarray(self.bias + self.scales(distance) * stdtrit(self.freedom, shares))

    def shares(self, errors: Floats, distance: Floats) -> Floats:
        """The inverse of `quantiles`."""
        return np.asarray(stdtr(self.freedom, (errors - self.bias) / self.scales(distance)))


@dataclass(frozen=True)
class Ghosts:
    """Detections of nothing.

    Args:
        rate: Mean number in a frame.
        seen: Ghosts that were seen: x, y and heading in the ego frame, height, width, length.
        seconds: Mean time for which one stays.
    """

    rate: float = 0.0
    seen: tuple[tuple[float, ...], ...] = ()
    seconds: float = 0.1


@dataclass(frozen=True)
class ErrorModel:
    """The errors of one detector under one attack.

    Args:
        found: Weights of `TERMS` in the log-odds of a detection.
        spreads: Distribution of each of `COMPONENTS`.
        turned_round: Probability that a heading is off by half a turn.
        ghosts: Detections of nothing.
        found_seconds: Time after which a miss or a detection is mostly forgotten.
        error_seconds: Time after which an error of place, heading or size is mostly forgotten.
        card: JSON-able: the detector with the hash of its weights, the attack, the data that it was
            fitted to, and how it compares with frames that it was not fitted to.
    """

    found: tuple[float, ...] = (50.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    spreads: Mapping[str, Spread] = field(default_factory=lambda: {n: Spread() for n in COMPONENTS})
    turned_round: float = 0.0
    ghosts: Ghosts = Ghosts()
    found_seconds: float = 0.5
    error_seconds: float = 0.5
    card: Mapping[str, Any] = field(default_factory=dict)

    def probabilities(self, boxes: Boxes3D, views: ObjectViews) -> Floats:
        """How surely each object is detected, shape (N,)."""
        return np.asarray(expit(terms(boxes, views) @ np.array(self.found)))

    def to_json(self) -> dict[str, Any]:
        """The model for a file."""
        return {"format": FORMAT, "kind": "error model", **asdict(self)}


def terms(boxes: Boxes3D, views: ObjectViews) -> Floats:
    """`TERMS` of each object, shape (N, 6)."""
    distance = np.minimum(views.distance, FARTHEST) / UNIT
    not_car = (boxes.category != "Car").astype(float)
    ones = np.ones_like(distance)
    return np.column_stack([ones, distance, distance**2, views.hidden, views.outside, not_car])


def write_error_model(path: str | Path, model: ErrorModel, *, overwrite: bool = False) -> None:
    """Write a model as JSON, whole or not at all.

    Raises:
        DataError: The file exists and `overwrite` is false, or it cannot be written.
    """
    text = json.dumps(model.to_json(), allow_nan=False, indent=1)
    write_bytes(path, text.encode(), overwrite=overwrite)


def read_error_model(path: str | Path) -> ErrorModel:
    """Read what `write_error_model` wrote.

    Raises:
        DataError: Missing, damaged, or something else.
    """
    content = read_json_object(path, remedy=_REMEDY)
    if (content.get("kind"), content.get("format")) != ("error model", FORMAT):
        raise DataError("The file holds no error model.", path=path, remedy=_REMEDY)
    try:
        ghosts = content["ghosts"]
        model = ErrorModel(
            found=_numbers(content["found"], len(TERMS)),
            spreads={
                name: Spread(
                    **dict(
                        zip(
                            Spread.__annotations__,
                            _numbers(
                                [content["spreads"][name][part] for part in Spread.__annotations__],
                                4,
                            ),
                            strict=True,
                        )
                    )
                )
                for name in COMPONENTS
            },
            turned_round=float(content["turned_round"]),
            ghosts=Ghosts(
                float(ghosts["rate"]),
                tuple(_numbers(ghost, 6) for ghost in ghosts["seen"]),
                float(ghosts["seconds"]),
            ),
            found_seconds=float(content["found_seconds"]),
            error_seconds=float(content["error_seconds"]),
            card=dict(content["card"]),
        )
        _check(model)
    except (KeyError, TypeError, ValueError) as error:
        raise DataError(f"The file is damaged: {error}.", path=path, remedy=_REMEDY) from error
    return model


def _numbers(values: Any, count: int) -> tuple[float, ...]:
    numbers = tuple(float(value) for value in values)
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise ValueError(f"{count} finite numbers are needed")
    return numbers


def _check(model: ErrorModel) -> None:
    ghosts = model.ghosts
    positive = [ghosts.seconds, model.found_seconds, model.error_seconds]
    positive += [
        part for spread in model.spreads.values() for part in (spread.scale, spread.freedom)
    ]
    if not all(abs(part) <= _LARGEST for ghost in ghosts.seen for part in ghost[:3]):
        raise ValueError("ghosts lie within a kilometre")
    sizes = [part for ghost in ghosts.seen for part in ghost[3:]]
    if not all(0 < value < 1e6 for value in positive + sizes):
        raise ValueError("times, scales and sizes are positive")
    if any(spread.freedom < _FEWEST for spread in model.spreads.values()):
        raise ValueError(f"degrees of freedom are {_FEWEST} or more")
    of_any_sign = [*model.found]
    of_any_sign += [
        part for spread in model.spreads.values() for part in (spread.bias, spread.growth)
    ]
    if not all(abs(value) < 1e6 for value in of_any_sign):
        raise ValueError("weights, biases and growths are below a million")
    if not 0 <= model.turned_round <= 1 or not 0 <= ghosts.rate < 1e3:
        raise ValueError("a probability lies in [0, 1], a rate of ghosts in [0, 1000)")
    if ghosts.rate > 0 and not ghosts.seen:
        raise ValueError("ghosts have a rate and no place")
