"""What is known of weights."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class ModelCard:
    """What is known of weights; JSON beside the file.

    Args:
        network: The name of the network, such as ``dsgn``.
        configuration: The configuration of the network.
        data: The data that the network was trained and validated on.
        training: Configuration of the training, seed among it.
        metrics: The metrics on the validation data, or on the frames that `avsec weights calibrate`
            was given, which then are in `data`.
        beside: What was learned with the network and is no part of it, such as weights of losses.
        steps: The number of training steps.
        epochs: The number of epochs.
        minutes: The minutes that it took, validations included.
        samples_seen: Training samples, each as often as it was seen.
        compute_seconds: The seconds of training steps alone.
        images_per_hour: Samples in an hour of steps.
        arithmetic: Numbers that the training calculated in, and why.
        hardware: The hardware that it ran on.
        command: The command that made the weights.
        before: Trainings whose weights this one began with, the first one first; see `trainings`.
        versions: The versions of what made them.
        source: The origin of weights that were not made here.
        license: The weights' licence, by its SPDX name; None where whoever made them has not said.
        parameters: How many numbers are learned.
        storage: The type of floating-point numbers in the file.
        sha256: The SHA-256 of the file.
    """

    network: str
    configuration: dict[str, Any] = field(default_factory=dict)
    data: dict[str, Any] = field(default_factory=dict)
    training: dict[str, Any] = field(default_factory=dict)
    metrics: dict[str, float] = field(default_factory=dict)
    beside: dict[str, list[float]] = field(default_factory=dict)
    steps: int | None = None
    epochs: int | None = None
    minutes: float | None = None
    samples_seen: int | None = None
    compute_seconds: float | None = None
    images_per_hour: float | None = None
    arithmetic: str | None = None
    hardware: str | None = None
    command: str | None = None
    before: list[dict[str, Any]] = field(default_factory=list)
    versions: dict[str, str] = field(default_factory=dict)
    source: str | None = None
    license: str | None = None
    parameters: int | None = None
    storage: str = "float16"
    sha256: str = ""

    def trainings(self) -> list[dict[str, Any]]:
        """One after the other, this one last: command, seed, epochs, steps, minutes, sha256."""
        facts = ("command", "epochs", "steps", "minutes", "sha256")
        this = {name: getattr(self, name) for name in facts} | {"seed": self.training.get("seed")}
        return [*self.before, this]
