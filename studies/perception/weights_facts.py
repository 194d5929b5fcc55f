"""What a results page states of a network's weights: the card's facts without its tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from avsec_gym.perception.weights.store import read_card

_FACTS = (
    "network",
    "sha256",
    "storage",
    "parameters",
    "hardware",
    "versions",
    "source",
    "metrics",
)


def weights_facts(path: Path | None) -> dict[str, Any] | None:
    """Of a file of weights; JSON-able, None where there is no file or no card.

    Raises:
        DataError: The card is none.
    """
    card = None if path is None else read_card(path)
    if path is None or card is None:
        return None
    facts = {name: getattr(card, name) for name in _FACTS}
    data = {use: _sources(card.data.get(use, ())) for use in ("training", "validation")}
    return facts | {
        "trainings": card.trainings(),
        "bytes": path.stat().st_size,
        "seed": card.training.get("seed"),
        "batch": card.training.get("batch"),
        "data": data,
    }


def _sources(described: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """How the frames were made, and how many they are."""
    sources = []
    for source in described:
        settings = source.get("settings") or {}
        sources.append(
            {
                "suite": settings.get("suite"),
                "seed": settings.get("seed"),
                "frames": source.get("frames"),
                "fingerprint": source.get("fingerprint"),
                "baseline": _baseline(settings),
            }
        )
    return sources


def _baseline(settings: Mapping[str, Any]) -> float | None:
    """Metres between the pair of cameras; None where there is none."""
    projections = (settings.get("rig") or {}).get("projections", ())
    cameras = settings.get("cameras") or ()
    if len(cameras) != 2 or max(cameras) >= len(projections):
        return None
    left, right = (projections[camera][0] for camera in cameras)
    return round(float(left[3] / left[0] - right[3] / right[0]), 3)
