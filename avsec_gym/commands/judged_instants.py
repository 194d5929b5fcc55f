"""What `avsec connected` reports of the instants that it judges: line by line, and in sum."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any, TypedDict

from avsec_gym import console
from avsec_gym.errors import DataError
from avsec_gym.json_schemas import with_schema
from avsec_gym.storage.text_files import write_text

if TYPE_CHECKING:
    from avsec_gym.validation.connected.attacks.attacked_instant import (
        AttackedInstant,
        InstantAttack,
    )
    from avsec_gym.validation.connected.fit import ConnectedFit
    from avsec_gym.validation.connected.recordings import RecordedInstant
    from avsec_gym.validation.connected.result import ConnectedResult
    from avsec_gym.validation.connected.sources import ConnectedSource
    from avsec_gym.validation.connected.validator import ConnectedValidator
    from avsec_gym.validation.validation_folder import ValidationFolder


class JudgedAttack(TypedDict):
    """What was attacked, and what came of it."""

    kind: str
    victim: int
    outcome: str


class InstantRow(TypedDict):
    """What is kept of an instant, as far as lines and summaries rely on it."""

    id: str
    alarm: bool
    accused: list[int]
    regions: int
    decidable: int
    accusations: list[dict[str, Any]]
    bytes: list[dict[str, int]]
    refused: list[Any]
    seconds: dict[str, float]
    attack: JudgedAttack | None
    attack_possible: bool
    vehicles: int


@dataclass(frozen=True)
class JudgedInstants:
    """Instants, a validator, and the folder that keeps its results.

    Args:
        source: The instants.
        validator: The validator that judges them.
        fit: What its constants were fitted on.
        folder: The folder of this question; what it knows already is not asked again.
        attack: The attack on each of the instants; None: they are judged as they were recorded.
        seed: Seed of the attack.
        pictures: Most pictures of alarms.
        as_json: Whether JSON lines are printed instead of words.
    """

    source: ConnectedSource
    validator: ConnectedValidator
    fit: ConnectedFit
    folder: ValidationFolder
    attack: InstantAttack | None
    seed: int
    pictures: int
    as_json: bool

    def judge(self) -> None:
        """Judge each instant, and report its result at once.

        Raises:
            ConfigurationError: The constants were fitted on another LiDAR.
            DataError: A file of the data is missing or broken.
        """
        known, total = self.folder.rows, len(self.source.names)
        with console.progress("comparing vehicles") as shown:
            for number, instant in enumerate(self.source.read()):
                if instant.id in known:
                    self._tell(known[instant.id])
                else:
                    self._judge_one(instant, number)
                if total:
                    shown(number + 1, total)

    def _judge_one(self, recorded: RecordedInstant, number: int) -> None:
        attacked = self.attack.attack(recorded, (self.seed, number)) if self.attack else None
        instant = recorded if attacked is None else attacked.instant
        # A rig is recognised by what was recorded, not by what an attacker made of it.
        self.fit.check(recorded.scans)
        result = self.validator.validate(instant.scans, id=instant.id)
        row = {
            **result.to_json(),
            "attack": None if attacked is None else _attack_row(attacked, result),
            "attack_possible": self.attack is None or attacked is not None,
            "vehicles": len(instant.scans),
        }
        drawn = sum(row["alarm"] for row in self.folder.rows.values())
        # The picture first: a row that is kept has its picture.
        if result.alarm and drawn < self.pictures:
            from avsec_gym.drawing.connected_picture import save_connected_picture

            save_connected_picture(
                self.folder.out / "alarms" / f"{instant.id.replace('/', '_')}.png",
                result,
                instant.scans,
                self.validator.constants.margins,
                self.fit.origin,
            )
        self.folder.add(row)
        self._tell(row)

    def report(self) -> int:
        """Sum up, in words or JSON and in ``summary.json``; the exit code."""
        found = summary(list(self.folder.rows.values()))
        found |= {"method": self.validator.method, "fitted_on": self.fit.origin}
        document = with_schema("connected.summary", found)
        path = self.folder.out / "summary.json"
        write_text(path, json.dumps(document, indent=1) + "\n", overwrite=True)
        if self.as_json:
            console.print_json_line("connected.summary", {"summary": found})
        else:
            rows = [
                [title, f"{found[key]['hits']} of {found[key]['cases']}", _percent(found[key])]
                for key, title in _RATES.items()
            ]
            console.print_table("instants", ["", "", "% (95 % interval)"], rows)
            console.say(
                f"avsec: a vehicle sent {found['bytes_largest']} bytes at most; an instant took "
                f"{found['seconds']:.2f} s, of which proposals {found['seconds_of']['propose']:.2f}"
                f" (medians); {self.folder.out} holds lines and pictures"
            )
        return console.DONE

    def _tell(self, row: dict[str, Any]) -> None:
        if self.as_json:
            console.print_json_line("connected.instant", row)
            return
        text = f"{row['id']}: {_status(row)}"
        if row["attack"] is not None:
            text += f"; the attack was a {row['attack']['kind']} on vehicle "
            text += f"{row['attack']['victim']}, {row['attack']['outcome']}"
        console.print_line(
            f"{text}; {row['decidable']} of {row['regions']} regions seen twice,"
            f" {max(_sent(row))} bytes a vehicle at most"
        )


_RATES = {
    "alarms": "alarms",
    "attacks_detected": "attacks detected, of all",
    "attacks_detected_decidable": "attacks detected, of those that some other vehicle sees",
    "victims_named": "victims named, of attacks detected",
    "wrongly_named": "honest vehicles named, of all instants",
}


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Rates with intervals, bytes and seconds of judged instants.

    Instants of one drive, or of one scenario of OPV2V, are one cluster of the intervals.

    Args:
        rows: Rows of `JudgedInstants`.

    Raises:
        DataError: No instant was judged.
    """
    if not rows:
        raise DataError("There was no instant to judge.")
    attacked = [row for row in rows if row["attack"] is not None]
    decidable = [row for row in attacked if row["attack"]["outcome"] != "not seen by two"]
    detected = [row for row in attacked if _is_detected(row)]
    steps = sorted({step for row in rows for step in row["seconds"]})
    return {
        "instants": len(rows),
        "not_attackable": sum(not row["attack_possible"] for row in rows),
        "alarms": _rate(rows, lambda row: bool(row["alarm"])),
        "attacks_detected": _rate(attacked, _is_detected),
        "attacks_detected_decidable": _rate(decidable, _is_detected),
        "victims_named": _rate(detected, lambda row: row["attack"]["outcome"] == "named"),
        "wrongly_named": _rate(rows, _wrongly_named),
        "decidable_share": _share(rows),
        "bytes_largest": max(max(_sent(row)) for row in rows),
        "bytes_median": median(size for row in rows for size in _sent(row)),
        "refused": sum(len(row["refused"]) for row in rows),
        "seconds": median(sum(row["seconds"].values()) for row in rows),
        "seconds_of": {
            step: median(row["seconds"].get(step, 0.0) for row in rows) for step in steps
        },
    }


def _attack_row(attacked: AttackedInstant, result: ConnectedResult) -> dict[str, Any]:
    """What was attacked, and what came of it, judged at the regions that are about it."""
    about = attacked.regions(result.regions)
    named = result.named[about]
    if not (about & result.decidable).any():
        outcome = "not seen by two"
    elif attacked.victim in named:
        outcome = "named"
    elif (named >= 0).any():
        outcome = "misnamed"
    else:
        outcome = "detected" if result.alarm and (named == -1).any() else "missed"
    return {
        "kind": attacked.kind,
        "victim": attacked.victim,
        "points": attacked.points,
        "centre": attacked.box.centre[0].round(2).tolist(),
        "outcome": outcome,
    }


def _rate(
    rows: Sequence[Mapping[str, Any]], hit: Callable[[Mapping[str, Any]], bool]
) -> dict[str, Any]:
    """Hits, cases, the rate and its 95 % interval; null without cases."""
    from avsec_gym.metrics.clustered_shares import share_of

    share = share_of([hit(row) for row in rows], [_recording(row["id"]) for row in rows])
    interval = share.interval and list(share.interval)
    return {"hits": share.count, "cases": share.of, "rate": share.rate, "interval": interval}


def _recording(id: str) -> str:
    """The drive or scenario of an instant; one of a data set has a place of its own."""
    return id.rpartition("/")[0] or id


def _is_detected(row: Mapping[str, Any]) -> bool:
    return row["attack"]["outcome"] in ("named", "detected", "misnamed")


def _wrongly_named(row: Mapping[str, Any]) -> bool:
    """Whether a vehicle is accused that was not attacked."""
    return bool(set(row["accused"]) - ({row["attack"]["victim"]} if row["attack"] else set()))


def _share(rows: list[dict[str, Any]]) -> float | None:
    regions = sum(row["regions"] for row in rows)
    return sum(row["decidable"] for row in rows) / regions if regions else None


def _sent(row: dict[str, Any]) -> list[int]:
    return [sum(each.values()) for each in row["bytes"]]


def _percent(rate: dict[str, Any]) -> str:
    return console.percent(rate["rate"], rate["interval"])


def _status(row: dict[str, Any]) -> str:
    if not row["alarm"]:
        return "no alarm"
    if row["accused"]:
        return f"ALARM, vehicle {', '.join(map(str, row['accused']))} is attacked"
    return "ALARM, cannot tell whose LiDAR"
