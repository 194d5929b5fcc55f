"""What is kept of each instant that `avsec connected` judges: a row of JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypedDict

if TYPE_CHECKING:
    from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
    from avsec_gym.validation.connected.recordings import RecordedInstant
    from avsec_gym.validation.connected.result import ConnectedResult


class JudgedAttack(TypedDict):
    """What was attacked, and what came of it."""

    kind: str
    victim: int
    outcome: str


class RegisteredScan(TypedDict):
    """How well a scan lies on the middle one of its instant, see `Registration`."""

    residual: float
    """Median distance of its points from the other's surface, metres."""
    overlap: float


class RegisteredRow(TypedDict, total=False):
    """What rows have where poses are by registration."""

    registrations: list[RegisteredScan | None]
    """Residuals of each scan; None of the middle one."""


class InstantRow(RegisteredRow):
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


def attack_row(attacked: AttackedInstant, result: ConnectedResult) -> dict[str, Any]:
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


def registered_row(recorded: RecordedInstant) -> RegisteredRow:
    """The entry of a row for the residuals of registered scans; none of measured poses."""
    from avsec_gym.validation.connected.raw_drive.drive_instants import DriveInstant

    if not isinstance(recorded, DriveInstant) or not recorded.registrations:
        return {}
    return {
        "registrations": [
            None
            if each is None
            else {"residual": round(each.residual, 4), "overlap": round(each.overlap, 4)}
            for each in recorded.registrations
        ]
    }


def drive_of(instant: RecordedInstant) -> str:
    """Name of the drive that an instant is of; instants of one are alike.

    Args:
        instant: What was recorded.
    """
    recording = instant.id.rpartition("/")[0]
    if recording or instant.truth is None:
        return recording or instant.id
    return str(instant.truth.drive)


def sent_bytes(row: Mapping[str, Any]) -> list[int]:
    """Bytes that each vehicle sent at an instant.

    Args:
        row: A row of `JudgedInstants`.
    """
    return [sum(each.values()) for each in row["bytes"]]
