"""What a results page states of a network's weights: the card's facts without its tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avsec_gym.experiments.json_rows import row_of
from avsec_gym.perception.weights.store import read_card


@dataclass(frozen=True)
class TrainingFacts:
    """One of the trainings that made weights; see `ModelCard`."""

    command: str | None
    epochs: int | None
    steps: int | None
    minutes: float | None
    sha256: str | None
    seed: int | None


@dataclass(frozen=True)
class SourceFacts:
    """How frames were made, and how many they are; None where their folder does not state it."""

    suite: str | None
    seed: int | None
    frames: int | None
    fingerprint: str | None
    baseline: float | None
    """Metres between the pair of cameras; None where there is none."""


@dataclass(frozen=True)
class DataFacts:
    """What weights were trained and validated on."""

    training: list[SourceFacts]
    validation: list[SourceFacts]


@dataclass(frozen=True)
class WeightsFacts:
    """Facts of a card; see `ModelCard`."""

    network: str
    sha256: str
    storage: str
    parameters: int | None
    hardware: str | None
    versions: Mapping[str, str]
    source: str | None
    metrics: Mapping[str, float]
    """The one that leads stands first."""
    trainings: Sequence[TrainingFacts]
    """One after the other; the last made these weights."""
    bytes: int
    """Size of the file."""
    seed: int | None
    batch: int | None
    data: DataFacts


def weights_facts(path: Path | None) -> WeightsFacts | None:
    """The facts of a file of weights; None where there is no file or no card.

    Raises:
        DataError: The card is none.
    """
    card = None if path is None else read_card(path)
    if path is None or card is None:
        return None
    return WeightsFacts(
        network=card.network,
        sha256=card.sha256,
        storage=card.storage,
        parameters=card.parameters,
        hardware=card.hardware,
        versions=card.versions,
        source=card.source,
        metrics=card.metrics,
        trainings=[row_of(TrainingFacts, training) for training in card.trainings()],
        bytes=path.stat().st_size,
        seed=card.training.get("seed"),
        batch=card.training.get("batch"),
        data=DataFacts(
            training=_sources(card.data.get("training", ())),
            validation=_sources(card.data.get("validation", ())),
        ),
    )


def _sources(described: Sequence[Mapping[str, Any]]) -> list[SourceFacts]:
    sources = []
    for source in described:
        settings = source.get("settings") or {}
        sources.append(
            SourceFacts(
                suite=settings.get("suite"),
                seed=settings.get("seed"),
                frames=source.get("frames"),
                fingerprint=source.get("fingerprint"),
                baseline=_baseline(settings),
            )
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
