"""What is kept of an instant in one state, as rows of a run and read back from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter4.settings import METHODS, ConnectedCondition, Part, State
from avsec_gym.geometry import Floats
from avsec_gym.runs.experiment import Measurement
from avsec_gym.runs.results import Results
from avsec_gym.validation.connected.result import Naming
from avsec_gym.validation.connected.validator import Method

_ATTACKED, _DECIDABLE, _DISTANCE = "attacked", "decidable", "distance"


@dataclass(frozen=True, eq=False)
class MeasuredState:
    """An instant without an attack, or under one.

    Args:
        place: Name of the place, which stands in one instant only.
        attacked: Whether something was attacked: not every scan offers something.
        decidable: Whether some vehicle has enough rays to decide on each region, shape (R,).
            Without an attack these are all regions, under one those about what was attacked.
        scores: The score of each region, by method; -inf where nothing was compared, shape (R,).
        named: The `Naming` of each region, by method, shape (R,); empty without an attack.
        distances: Distances of pairs of surfaces, metres, shape (D,): of all pairs, under an
            attack those of the victim (equation 4.1).
        nbytes: The bytes that each vehicle sent, by method, shape (V,); empty under an attack.
    """

    place: str
    attacked: bool
    decidable: NDArray[np.bool_]
    scores: Mapping[Method, Floats]
    named: Mapping[Method, NDArray[np.int64]]
    distances: Floats
    nbytes: Mapping[Method, NDArray[np.int64]]

    @property
    def covered(self) -> bool:
        """Whether some region is about what was attacked."""
        return self.attacked and len(self.decidable) > 0

    @property
    def is_decidable(self) -> bool:
        """Whether one of the regions is decidable."""
        return bool(self.decidable.any())

    def highest(self, method: Method) -> float:
        """The highest score of the decidable regions; -inf without any."""
        return float(self.scores[method][self.decidable].max(initial=-np.inf))

    def naming(self, method: Method) -> Naming:
        """The naming in the decidable region with the highest score."""
        if not self.is_decidable:
            return Naming.NO_ALARM
        best = np.where(self.decidable, self.scores[method], -np.inf).argmax()
        return Naming(int(self.named[method][best]))


def setting_of(part: Part, condition: ConnectedCondition, state: State) -> str:
    """The setting of a run's rows."""
    return f"{part}, {condition.name}, {state}"


def rows_of(measured: MeasuredState, setting: str) -> list[Measurement]:
    """The rows of a state.

    Args:
        measured: The state.
        setting: The setting, see `setting_of`.
    """
    columns = {_ATTACKED: [measured.attacked], _DECIDABLE: measured.decidable}
    columns[_DISTANCE] = measured.distances
    for method in METHODS:
        columns |= {
            _score(method): measured.scores[method],
            _named(method): measured.named[method],
            _nbytes(method): measured.nbytes[method],
        }
    return [
        # A run knows no infinity: NaN is nothing.
        Measurement(setting, measured.place, f"{column} {index}", value)
        for column, values in columns.items()
        for index, value in enumerate(_finite(values))
    ]


def measured_states(
    results: Results, part: Part, condition: ConnectedCondition, state: State
) -> list[MeasuredState]:
    """The states that a run holds, by place.

    What a cell of an earlier format left, which knew fewer methods, is none: it is done again.

    Args:
        results: The results of a run.
        part: `FITTED` or `JUDGED`.
        condition: The condition.
        state: The state.
    """
    setting = setting_of(part, condition, state)
    found: dict[str, dict[str, dict[int, float]]] = {}
    for row in results.measurements(setting=setting):
        column, _, index = row.name.rpartition(" ")
        found.setdefault(row.scenario, {}).setdefault(column, {})[int(index)] = row.value
    return [
        _state(place, columns) for place, columns in sorted(found.items()) if _is_whole(columns)
    ]


def _is_whole(columns: Mapping[str, Mapping[int, float]]) -> bool:
    """Whether each method has a score of each region."""
    regions = len(columns.get(_DECIDABLE, {}))
    return all(len(columns.get(_score(method), {})) == regions for method in METHODS)


def _state(place: str, columns: Mapping[str, Mapping[int, float]]) -> MeasuredState:
    def column(name: str) -> Floats:
        values = columns.get(name, {})
        return np.array([values[index] for index in sorted(values)], float)

    return MeasuredState(
        place,
        bool(column(_ATTACKED)[0]),
        column(_DECIDABLE).astype(bool),
        {method: np.nan_to_num(column(_score(method)), nan=-np.inf) for method in METHODS},
        {method: column(_named(method)).astype(np.int64) for method in METHODS},
        column(_DISTANCE),
        {method: column(_nbytes(method)).astype(np.int64) for method in METHODS},
    )


def _score(method: Method) -> str:
    return f"{method} score"


def _named(method: Method) -> str:
    return f"{method} named"


def _nbytes(method: Method) -> str:
    return f"{method} bytes"


def _finite(values: object) -> Iterator[float]:
    for value in np.asarray(values, float).tolist():
        yield value if np.isfinite(value) else float("nan")
