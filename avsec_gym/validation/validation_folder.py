"""What a validator said of a recording, as a folder: a JSON line for each moment, as they come."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.kitti.text_files import read_text, write_text
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.sensor_system import Sensor
from avsec_gym.validation.validator import Validation

RECORD, ROWS = "validation.json", "moments.jsonl"
"""Whose results these are; the results."""
THRESHOLDS, LIKELIHOOD, SAMPLES = "thresholds.json", "likelihood.json", "samples.jsonl"
"""What errors were like when nobody attacked; the model; the moments that it was fitted on."""


class ValidationFolder:
    """Goes on where an earlier run with the same record was stopped.

    Args:
        out: New, empty, or with results of the same record.
        record: JSON-able: everything that decides the results.

    Raises:
        DataError: The folder holds other results.
    """

    def __init__(self, out: Path, record: Mapping[str, Any]) -> None:
        self.out = out
        text = json.dumps(record, indent=1) + "\n"
        place = out / RECORD
        if place.exists() and read_text(place) != text:
            raise DataError(
                "The results here are of another recording, other sensors or other settings.",
                path=out,
                remedy="Name another --out, or take this folder away.",
            )
        write_text(place, text, overwrite=True)
        self._lines = JsonLines(out / ROWS)

    @property
    def rows(self) -> dict[str, dict[str, Any]]:
        """By the moments' ids."""
        return self._lines.rows

    def add(self, row: dict[str, Any]) -> None:
        """Keep what was said of a moment."""
        self._lines.add(row)


class JsonLines:
    """Rows with an ``id``, a line each; a last line that was cut off is done again.

    Args:
        path: The file, new or not.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        lines = read_text(path).split("\n")[:-1] if path.exists() else []
        self.rows: dict[str, dict[str, Any]] = {row["id"]: row for row in map(json.loads, lines)}
        write_text(path, "".join(line + "\n" for line in lines), overwrite=True)

    def add(self, row: dict[str, Any]) -> None:
        """Keep it, at once."""
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row, allow_nan=False) + "\n")
        self.rows[row["id"]] = row


def row_of(
    id: str, validation: Validation, attacked: frozenset[Sensor], seconds: float
) -> dict[str, Any]:
    """What is kept of a moment; JSON-able.

    Args:
        id: Of the moment.
        validation: What was said of it.
        attacked: The sensors that were attacked on purpose, to see whether it is noticed.
        seconds: From the sensors' data in memory to the verdict.
    """
    sensors = validation.errors.maps.system.sensors
    named = {f"{i},{j},{k}": validation.errors[i, j, k] for i, j, k in validation.errors.known}
    return {
        "id": id,
        "alarm": validation.alarm,
        "attacked": [sensor for sensor in sensors if sensor in validation.attacked],
        "verdicts": {str(sensor): str(said) for sensor, said in validation.verdicts.items()},
        "probabilities": validation.probabilities
        and {str(sensor): round(p, 6) for sensor, p in validation.probabilities.items()},
        "errors": {name: round(one.error, 6) for name, one in named.items()},
        "hole_shares": {name: round(one.hole_share, 6) for name, one in named.items()},
        "truly_attacked": [sensor for sensor in sensors if sensor in attacked],
        "seconds": round(seconds, 4),
    }


def summary(rows: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Alarms and names over all moments; rates with 95 % Wilson intervals, None without a case.

    ``attacks_named`` counts the moments in which exactly the attacked sensors were named; three
    sensors can name none.
    """
    clean = [row for row in rows.values() if not row["truly_attacked"]]
    attacked = [row for row in rows.values() if row["truly_attacked"]]
    names: dict[str, int] = {}
    for row in rows.values():
        for sensor in row["attacked"]:
            names[str(sensor)] = names.get(str(sensor), 0) + 1
    seconds = sorted(row["seconds"] for row in rows.values())
    exact = [
        row["attacked"] == row["truly_attacked"] for row in attacked if len(row["verdicts"]) > 3
    ]
    return {
        "moments": len(rows),
        "alarms": sum(row["alarm"] for row in rows.values()),
        "attacked_sensors": names,
        "alarms_without_attack": _rate([row["alarm"] for row in clean]),
        "attacks_noticed": _rate([row["alarm"] for row in attacked]),
        "attacks_named": _rate(exact),
        "median_seconds": seconds[len(seconds) // 2] if seconds else None,
    }


def _rate(hits: list[bool]) -> dict[str, Any]:
    low, high = wilson_interval(sum(hits), len(hits))
    return {
        "count": sum(hits),
        "of": len(hits),
        "rate": sum(hits) / len(hits) if hits else None,
        "interval": [low, high] if hits else None,
    }
