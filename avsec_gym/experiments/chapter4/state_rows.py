"""What is kept of an instant as rows of a run, and read back from them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from avsec_gym.experiments.chapter4.measured_state import KnownAttack, MeasuredState
from avsec_gym.experiments.chapter4.settings import (
    BY_GEOMETRY,
    BY_RAYS,
    METHODS,
    NAMERS,
    ConnectedCondition,
    Part,
    State,
)
from avsec_gym.geometry import Floats
from avsec_gym.runs.experiment import Measurement
from avsec_gym.runs.results import Results

CATEGORIES = (
    "",
    "Car",
    "Van",
    "Truck",
    "Pedestrian",
    "Person_sitting",
    "Cyclist",
    "Tram",
    "Misc",
)
"""Categories by the number that stands for each in a row; the first is that of what has none."""
_ATTACK, _DISTANCE, _PAIRS, _WITNESSES = "attack", "distance", "pairs", "witnesses by rays"
_SENT, _FROM_STATION = "sent", "from station"


def setting_of(part: Part, condition: ConnectedCondition, state: State) -> str:
    """The setting of a run's rows."""
    return f"{part}, {condition.name}, {state}"


def rows_of(measured: MeasuredState, setting: str) -> list[Measurement]:
    """The rows of a state.

    Args:
        measured: The state.
        setting: The setting, see `setting_of`.
    """
    columns: dict[str, object] = {_ATTACK: _of_attack(measured.attack)}
    columns |= {_decidable(by): measured.decidable[by] for by in (BY_GEOMETRY, BY_RAYS)}
    columns |= {_DISTANCE: measured.distances, _PAIRS: [measured.pairs]}
    columns[_WITNESSES] = [measured.witnesses_by_rays]
    for method in METHODS:
        columns |= {
            _score(method): measured.scores[method],
            _probability(method): measured.probabilities[method],
            _seconds(method): [measured.seconds[method]],
        }
    for namer in NAMERS:
        columns |= {_named(namer): measured.named[namer], _honest(namer): [measured.honest[namer]]}
    columns |= {f"{_SENT}: {kind}": each for kind, each in measured.sent.items()}
    columns |= {f"{_FROM_STATION}: {kind}": [each] for kind, each in measured.from_station.items()}
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

    What a cell of an earlier format left, which kept less, is none: it is done again.

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
    """Whether each method has a score of each region, and all else is there."""
    regions = len(columns.get(_decidable(BY_GEOMETRY), {}))
    of_regions = [_score(method) for method in METHODS] + [
        _probability(method) for method in METHODS
    ]
    scalars = [_ATTACK, _PAIRS, _WITNESSES, *(_seconds(method) for method in METHODS)]
    scalars += [_honest(namer) for namer in NAMERS]
    return all(len(columns.get(name, {})) == regions for name in of_regions) and all(
        name in columns for name in scalars
    )


def _state(place: str, columns: Mapping[str, Mapping[int, float]]) -> MeasuredState:
    def column(name: str) -> Floats:
        values = columns.get(name, {})
        return np.array([values[index] for index in sorted(values)], float)

    def of_kinds(beginning: str) -> dict[str, Floats]:
        names = [name for name in columns if name.startswith(f"{beginning}: ")]
        return {name.removeprefix(f"{beginning}: "): column(name) for name in names}

    return MeasuredState(
        place,
        _attack_of(column(_ATTACK)),
        {by: column(_decidable(by)).astype(bool) for by in (BY_GEOMETRY, BY_RAYS)},
        {method: np.nan_to_num(column(_score(method)), nan=-np.inf) for method in METHODS},
        {method: column(_probability(method)) for method in METHODS},
        {namer: column(_named(namer)).astype(np.int64) for namer in NAMERS},
        {namer: int(column(_honest(namer))[0]) for namer in NAMERS},
        column(_DISTANCE),
        int(column(_PAIRS)[0]),
        int(column(_WITNESSES)[0]),
        {method: float(column(_seconds(method))[0]) for method in METHODS},
        {kind: sent.astype(np.int64) for kind, sent in of_kinds(_SENT).items()},
        {kind: int(sent[0]) for kind, sent in of_kinds(_FROM_STATION).items()},
    )


def _of_attack(attack: KnownAttack | None) -> list[float]:
    """Whether there was one; its witnesses, distance and category."""
    if attack is None:
        return [0.0]
    return [1.0, attack.witnesses, attack.distance, CATEGORIES.index(attack.category)]


def _attack_of(values: Floats) -> KnownAttack | None:
    """The inverse of `_of_attack`."""
    if not values[0]:
        return None
    _, witnesses, distance, category = values.tolist()
    return KnownAttack(int(witnesses), distance, CATEGORIES[int(category)])


def _decidable(by: str) -> str:
    return f"decidable by {by}"


def _score(method: str) -> str:
    return f"{method} score"


def _probability(method: str) -> str:
    return f"{method} probability"


def _seconds(method: str) -> str:
    return f"{method} seconds"


def _named(namer: str) -> str:
    return f"{namer} named"


def _honest(namer: str) -> str:
    return f"{namer} honest"


def _finite(values: object) -> Iterator[float]:
    for value in np.asarray(values, float).tolist():
        yield value if np.isfinite(value) else float("nan")
