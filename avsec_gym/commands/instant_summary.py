"""The rates, bytes and seconds over all instants that `avsec connected` judged."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from statistics import median
from typing import Any

from avsec_gym.commands.instant_rows import sent_bytes
from avsec_gym.errors import DataError


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
        "bytes_largest": max(max(sent_bytes(row)) for row in rows),
        "bytes_median": median(size for row in rows for size in sent_bytes(row)),
        "refused": sum(len(row["refused"]) for row in rows),
        "seconds": median(sum(row["seconds"].values()) for row in rows),
        "seconds_of": {
            step: median(row["seconds"].get(step, 0.0) for row in rows) for step in steps
        },
    }


def _rate(
    rows: Sequence[Mapping[str, Any]], hit: Callable[[Mapping[str, Any]], bool]
) -> dict[str, Any]:
    """Hits, cases, the rate and its 95 % interval; null without cases."""
    from avsec_gym.metrics.clustered_shares import share_of

    share = share_of(
        [hit(row) for row in rows], [row.get("drive") or _recording(row["id"]) for row in rows]
    )
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
