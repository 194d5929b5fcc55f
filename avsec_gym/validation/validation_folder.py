"""The results of a validator on a recording, as a folder: a JSON line for each frame."""

from __future__ import annotations

import json
from collections.abc import Mapping
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict

from avsec_gym.errors import DataError
from avsec_gym.json_schemas import with_schema
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.sensor_system import Sensor, Triple
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.json_lines import JsonLines
from avsec_gym.storage.portable_names import portable
from avsec_gym.storage.regular_files import is_there
from avsec_gym.storage.text_files import write_text
from avsec_gym.validation.evidence.disparity_error import MEASURES
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Validation

if TYPE_CHECKING:
    from avsec_gym.validation.repair.damage import Damage

FORMAT = 5
"""Raised when a row changes: a run does not go on with rows of an earlier format."""
_TIMES, _LONGEST = ("seconds", "locating_seconds"), 1e6
"""Fields of a row, and the most seconds that a frame takes: eleven days."""
_AWAY = "Name another --out, or take this folder away."
RECORD, ROWS = "validation.json", "frames.jsonl"
"""The files: whose results these are; the results."""
THRESHOLDS, LIKELIHOOD, SAMPLES = "thresholds.json", "likelihood.json", "samples.jsonl"
"""The errors of clean frames; the model; what was measured of the frames that it was fitted on."""


class ExceededShare(TypedDict):
    """A share that is beyond its threshold."""

    sensors: list[str | int]
    """Three: which is compared with which, as which sees it."""
    share: Literal["error", "hole_share", "densest", "brightness"]
    """One of `MEASURES`."""
    value: float
    threshold: float


class DamageRow(TypedDict, total=False):
    """How much of a sensor is damaged, as `Damage.row` makes it."""

    share_of_pixels: float
    points: int
    lost_directions: int
    unknown: str


class FrameRow(TypedDict):
    """What is kept of a frame, as `row_of` makes it."""

    id: str
    alarm: bool
    attacked: list[str | int]
    statuses: dict[str, SensorStatus]
    probabilities: dict[str, float] | None
    shares: dict[str, dict[str, float]]
    exceeded: list[ExceededShare]
    damage: dict[str, DamageRow]
    truly_attacked: list[str | int]
    seconds: float
    locating_seconds: float | None


class ValidationFolder:
    """Goes on where an earlier run with the same record was stopped.

    Args:
        out: New, empty, or with results of the same record.
        record: JSON-able: everything that decides the results, ``sensors`` by their names.
        kind: A `typing.TypedDict`: the fields of a row.

    Raises:
        DataError: The folder holds other results, or damaged ones.
    """

    def __init__(self, out: Path, record: Mapping[str, Any], kind: type[Any] = FrameRow) -> None:
        self.out = out
        if others := differences(out, record):
            raise DataError(
                f"The results here are of something else: {'; '.join(others)}.",
                path=out,
                remedy=_AWAY,
            )
        text = json.dumps(portable({"rows": FORMAT, **record}), indent=1) + "\n"
        write_text(out / RECORD, text, overwrite=True)
        self._lines = JsonLines(out / ROWS, kind)
        if kind is FrameRow:
            self._check_sensors({str(sensor) for sensor in record["sensors"]})
            self._check_seconds()

    @property
    def rows(self) -> dict[str, dict[str, Any]]:
        """The rows by the frames' ids."""
        return self._lines.rows

    def add(self, row: dict[str, Any]) -> None:
        """Keep the result of a frame, in place of an earlier one of its id."""
        if self.rows.pop(row["id"], None) is not None:
            others = "".join(json.dumps(other) + "\n" for other in self.rows.values())
            write_text(self.out / ROWS, others, overwrite=True)
        self._lines.add(row)

    def _check_sensors(self, known: set[str]) -> None:
        """Raise DataError where a row names a sensor that is not judged."""
        for id, row in self.rows.items():
            triples = [beyond["sensors"] for beyond in row["exceeded"]]
            named = [*row["attacked"], *row["truly_attacked"], *row["statuses"], *row["damage"]]
            named += [*(row["probabilities"] or ()), *chain.from_iterable(triples)]
            strange = sorted({str(sensor) for sensor in named} - known)
            if strange or any(len(triple) != 3 for triple in triples):
                raise DataError(
                    f"The row of {id!r:.60} names {strange or 'more or less than three sensors'}, "
                    f"which are not those that are judged: {' '.join(sorted(known))}.",
                    path=self.out / ROWS,
                    remedy="Take the line out: its frame is then judged again.",
                )

    def _check_seconds(self) -> None:
        """Raise DataError where a row states a time that no frame takes."""
        for id, row in self.rows.items():
            if not all(0 <= row[name] <= _LONGEST for name in _TIMES if row[name] is not None):
                raise DataError(
                    f"The row of {id!r:.60} has seconds that no frame takes.",
                    path=self.out / ROWS,
                    remedy="Take the line out: its frame is then judged again.",
                )


def differences(out: Path, record: Mapping[str, Any]) -> list[str]:
    """Differences between a folder's record and another: ``seed 1, not 0``; empty without results.

    Args:
        out: The folder, there or not.
        record: The record to compare with, see `ValidationFolder`.
    """
    if not any(is_there(out / name) for name in (ROWS, THRESHOLDS, LIKELIHOOD, SAMPLES)):
        return []
    return record_differences(out / RECORD, {"rows": FORMAT, **record}, _AWAY)


def record_differences(path: Path, record: Mapping[str, Any], remedy: str) -> list[str]:
    """Differences between the record in a file and another, see `differences`.

    Args:
        path: The file, there or not.
        record: The record to compare with; JSON-able.
        remedy: What helps where the file is damaged, a sentence.

    Raises:
        DataError: The file is damaged.
    """
    there = portable(read_json_object(path, remedy=remedy)) if is_there(path) else {}
    if not there:
        return [f"there is no {path.name} that states whose they are"]
    asked = json.loads(json.dumps(portable(record)))
    return [
        f"{name} {there.get(name)}, not {asked.get(name)}"
        for name in {**asked, **there}
        if there.get(name) != asked.get(name)
    ]


def usual_folder(usual: Path, record: Mapping[str, Any]) -> Path:
    """The first of ``NAME``, ``NAME_2`` and so on that holds no results of something else.

    Args:
        usual: The first of them.
        record: The record of the results, see `ValidationFolder`.
    """
    places = (usual.with_name(f"{usual.name}_{number}") for number in count(2))
    return next(out for out in chain([usual], places) if not differences(out, record))


def row_of(
    id: str,
    validation: Validation,
    attacked: frozenset[Sensor],
    damage: Mapping[Sensor, Damage],
    seconds: tuple[float, float],
) -> dict[str, Any]:
    """The row that is kept of a frame; JSON-able.

    Args:
        id: The id of the frame.
        validation: The result of the validator.
        attacked: The sensors that were attacked on purpose, to see whether it is detected.
        damage: The damage in the named sensors; empty if it was not located.
        seconds: The time from the sensors' data in memory to the statuses, and from there to the
            damage.
    """
    sensors, errors = validation.errors.maps.system.sensors, validation.errors

    def whose(triple: Triple) -> list[Sensor]:
        return [sensors[position] for position in triple]

    row = {
        "id": id,
        "alarm": validation.alarm,
        "attacked": [sensor for sensor in sensors if sensor in validation.attacked],
        "statuses": {str(sensor): str(status) for sensor, status in validation.statuses.items()},
        "probabilities": validation.probabilities
        and {str(sensor): round(p, 6) for sensor, p in validation.probabilities.items()},
        "shares": {
            ",".join(map(str, whose(triple))): {
                name: round(getattr(errors[triple], name), 6) for name in MEASURES
            }
            for triple in errors.known
        },
        "exceeded": [
            {
                "sensors": whose(beyond.triple),
                "share": beyond.share,
                "value": round(beyond.value, 6),
                "threshold": round(beyond.threshold, 6),
            }
            for beyond in validation.exceeded
        ],
        "damage": {str(sensor): found.row for sensor, found in damage.items()},
        "truly_attacked": [sensor for sensor in sensors if sensor in attacked],
        "seconds": round(seconds[0], 4),
        "locating_seconds": round(seconds[1], 4) if damage else None,
    }
    return with_schema("validate.frame", row)


def summary(
    rows: Mapping[str, Mapping[str, Any]], drives: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Alarms and names over all frames; rates with 95 % intervals, None without a case.

    ``alarms_as_recorded`` counts alarms on frames that were not attacked on purpose: false alarms,
    unless an attacker was there during the recording.  ``attacks_named`` counts the frames in which
    exactly the attacked sensors were named; by thresholds, three sensors can name none.

    Args:
        rows: The row of each frame, by its id.
        drives: The drive of a frame, by its id: frames of one drive are alike, and one cluster of
            the intervals; a frame without a drive stands alone.
    """
    of = drives or {}
    as_recorded = {id: row for id, row in rows.items() if not row["truly_attacked"]}
    attacked = {id: row for id, row in rows.items() if row["truly_attacked"]}
    names: dict[str, int] = {}
    for row in rows.values():
        for sensor in row["attacked"]:
            names[str(sensor)] = names.get(str(sensor), 0) + 1
    seconds = sorted(row["seconds"] for row in rows.values())
    exact = {
        id: row["attacked"] == row["truly_attacked"]
        for id, row in attacked.items()
        if len(row["statuses"]) > 3 or row["probabilities"] is not None
    }
    return {
        "frames": len(rows),
        "alarms": sum(row["alarm"] for row in rows.values()),
        "attacked_sensors": names,
        "alarms_as_recorded": _rate({id: row["alarm"] for id, row in as_recorded.items()}, of),
        "attacks_detected": _rate({id: row["alarm"] for id, row in attacked.items()}, of),
        "attacks_named": _rate(exact, of),
        "median_seconds": seconds[len(seconds) // 2] if seconds else None,
    }


def _rate(hits: Mapping[str, bool], drives: Mapping[str, str]) -> dict[str, Any]:
    share = share_of([*hits.values()], [drives.get(id, id) for id in hits])
    interval = share.interval and list(share.interval)
    return {"count": share.count, "of": share.of, "rate": share.rate, "interval": interval}
