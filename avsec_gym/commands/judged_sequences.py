"""What `avsec connected --sequence` reports of drives: the evidence of successive instants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from avsec_gym.metrics.clustered_shares import Share
    from avsec_gym.validation.connected.rays.sequential import SequentialTest


@dataclass(frozen=True)
class SequenceRow:
    """What adds up over the instants of a drive.

    Args:
        drive: Name of the drive.
        instants: Number of its instants.
        windows: Number of windows that do not overlap, the last one of which may be shorter.
        alarms: Number of windows that alarm.
        alarm: The first instant of an alarm; None without one.
        highest: The highest sum of a window, nats.
        attacked: Whether one of its instants was attacked.
    """

    drive: str
    instants: int
    windows: int
    alarms: int
    alarm: str | None
    highest: float
    attacked: bool


@dataclass(frozen=True)
class JudgedSequences:
    """The test over windows of successive instants.

    Args:
        test: The test.
        frames: Number of instants of a window.
    """

    test: SequentialTest
    frames: int

    def rows(
        self, judged: Sequence[Mapping[str, Any]], drives: Mapping[str, str]
    ) -> list[SequenceRow]:
        """What adds up over each drive, in the order of their first instants.

        Args:
            judged: Rows of `JudgedInstants` in the order of their instants.
            drives: The drive of each instant, by the instant's id.
        """
        of_drive: dict[str, list[Mapping[str, Any]]] = {}
        for row in judged:
            of_drive.setdefault(drives[row["id"]], []).append(row)
        return [self._row(drive, rows) for drive, rows in of_drive.items()]

    def _row(self, drive: str, rows: Sequence[Mapping[str, Any]]) -> SequenceRow:
        # An instant in which nothing was compared has no score, and leaves the sum as it is.
        scores = np.array([row["score"] for row in rows], float)
        starts = range(0, len(scores), self.frames)
        windows = [scores[start : start + self.frames] for start in starts]
        found = [
            None if (frame := self.test.alarm(window)) is None else start + frame
            for start, window in zip(starts, windows, strict=True)
        ]
        alarms = [frame for frame in found if frame is not None]
        return SequenceRow(
            drive,
            len(rows),
            len(windows),
            len(alarms),
            rows[alarms[0]]["id"] if alarms else None,
            max(float(self.test.sums(window).max(initial=0.0)) for window in windows),
            any(row["attack"] is not None for row in rows),
        )

    def summary(self, rows: Sequence[SequenceRow]) -> dict[str, Any]:
        """Shares of windows, and of drives, that alarm; windows of one drive are one cluster.

        Args:
            rows: All drives.
        """
        from avsec_gym.metrics.clustered_shares import share_of

        of_windows = [
            (row.drive, number < row.alarms) for row in rows for number in range(row.windows)
        ]
        windows = share_of([alarm for _, alarm in of_windows], [drive for drive, _ in of_windows])
        drives = share_of([row.alarms > 0 for row in rows], [row.drive for row in rows])
        return {
            "frames": self.frames,
            **asdict(self.test),
            "windows": _listed(windows),
            "drives": _listed(drives),
        }


def drive_line(row: SequenceRow) -> str:
    """A drive in words."""
    status = "no alarm" if row.alarm is None else f"ALARM from {row.alarm} on"
    return (
        f"drive {row.drive}: {status}; the evidence of {row.instants} instants adds up to"
        f" {row.highest:.1f}, {row.alarms} of {row.windows} windows alarm"
    )


def _listed(share: Share) -> dict[str, Any]:
    interval = share.interval and list(share.interval)
    return {"hits": share.count, "cases": share.of, "rate": share.rate, "interval": interval}
