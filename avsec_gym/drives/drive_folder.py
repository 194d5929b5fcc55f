"""The results of drives as a folder: a row and a film for each, kept as soon as it is made."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from avsec_gym.closed_loop.drive_film import DriveFilm, read_film
from avsec_gym.drives.camera_views import write_views
from avsec_gym.drives.drive_row import DriveRow, DriveSeconds, drive_id
from avsec_gym.drives.one_drive import Driven
from avsec_gym.errors import DataError
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.folders import make_folder
from avsec_gym.storage.json_files import parse_json, read_json_object
from avsec_gym.storage.json_lines import JsonLines
from avsec_gym.storage.portable_names import portable
from avsec_gym.storage.regular_files import is_there
from avsec_gym.storage.text_files import write_text

FORMAT = 3
"""Raised when a row or a film changes: nothing goes on with those of an earlier format."""
RECORD, ROWS, SECONDS, FILMS = "drives.json", "drives.jsonl", "seconds.jsonl", "films"
"""What was asked for; a row for each drive; how long each took; a film for each."""
_AWAY = "Name another --out, or take this folder away."


class DriveFolder:
    """Goes on where earlier drives of the same record were stopped.

    All but `SECONDS` is the same, byte for byte, however often the drives were stopped and however
    many processes made them.

    Args:
        out: New, empty, or with results of the same record.
        record: JSON-able: everything that decides the results, ``settings`` by their names.

    Raises:
        DataError: The folder holds other results, or damaged ones.
    """

    def __init__(self, out: Path, record: Mapping[str, Any]) -> None:
        self.out = out
        if others := differences(out, record):
            raise DataError(
                f"The drives here are others: {'; '.join(others)}.", path=out, remedy=_AWAY
            )
        make_folder(out)
        write_text(out / RECORD, _text(record), overwrite=True)
        self._rows = JsonLines(out / ROWS, DriveRow)
        self._seconds = JsonLines(out / SECONDS, DriveSeconds)
        self._check_settings(record)
        self._check_seconds()

    @property
    def rows(self) -> dict[str, DriveRow]:
        """The rows by the drives' ids."""
        return cast("dict[str, DriveRow]", self._rows.rows)

    @property
    def seconds(self) -> dict[str, float]:
        """How long each drive took, by its id."""
        return {id: float(row["seconds"]) for id, row in self._seconds.rows.items()}

    def add(self, driven: Driven) -> None:
        """Keep a drive; its row comes last, so that a drive with a row has everything else."""
        id = driven.row["id"]
        write_bytes(self._film(id), driven.film.content(), overwrite=True)
        write_views(self.out, id, driven.views)
        self._seconds.add({"id": id, "seconds": round(driven.seconds, 4)})
        self._rows.add(driven.row)

    def film(self, id: str) -> DriveFilm:
        """The film of a drive.

        Raises:
            DataError: It is missing or damaged.
        """
        return read_film(self._film(id))

    def _check_settings(self, record: Mapping[str, Any]) -> None:
        """Raise DataError where a row is of a drive that was not asked for."""
        for id, row in self.rows.items():
            own = drive_id(row["setting"], row["scenario"], row["intention"])
            if own != id or row["setting"] not in record["settings"]:
                raise DataError(
                    f"The row {id!r:.80} is of the setting {row['setting']!r:.40}, the scene "
                    f"{row['scenario']!r:.40} and the intention {row['intention']!r:.40}.",
                    path=self.out / ROWS,
                    remedy="Take the line out: its drive is then driven again.",
                )

    def _check_seconds(self) -> None:
        """Raise DataError where a drive lacks what is kept before its row."""
        if without := [id for id in self.rows if id not in self._seconds.rows]:
            raise DataError(
                f"The seconds of {len(without)} drives are missing, of {without[0]!r:.80} first.",
                path=self.out / SECONDS,
                remedy=f"Take their lines out of {ROWS}: these drives are then driven again.",
            )

    def _film(self, id: str) -> Path:
        return film_file(self.out, id)


def film_file(out: Path, id: str) -> Path:
    """Where a folder of drives keeps the film of one.

    Args:
        out: The folder.
        id: The drive's id.
    """
    return out / FILMS / f"{id.replace('/', '_')}.npz"


def has_drives(out: Path) -> bool:
    """Whether a folder holds results of drives, of whichever."""
    return is_there(out / ROWS)


def differences(out: Path, record: Mapping[str, Any]) -> list[str]:
    """Differences between a folder's record and another: ``seed 1, not 0``; empty without drives.

    Args:
        out: The folder, there or not.
        record: The record to compare with, see `DriveFolder`.
    """
    if not has_drives(out):
        return []
    if not is_there(out / RECORD):
        return [f"there is no {RECORD} that states whose they are"]
    there = portable(read_json_object(out / RECORD, remedy=_AWAY))
    asked = parse_json(_text(record))
    return [
        f"{name} {there.get(name)}, not {asked.get(name)}"
        for name in {**asked, **there}
        if there.get(name) != asked.get(name)
    ]


def _text(record: Mapping[str, Any]) -> str:
    return json.dumps(portable({"format": FORMAT, **record}), indent=1) + "\n"
