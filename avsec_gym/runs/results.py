"""What experiments read of a run: rows by setting and strength, wherever they are stored."""

from __future__ import annotations

from typing import Any, Protocol

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.runs.experiment import Measurement


class Results(Protocol):
    """The part of `avsec_gym.runs.run_folder.RunFolder` that summaries need."""

    def settings(self) -> list[tuple[str, float]]:
        """Every setting and strength that there are rows of."""
        ...

    def records(self, **where: Any) -> list[SafetyRecord]:
        """Episodes, sorted by scenario and intention."""
        ...

    def detections(self, setting: str, strength: float = 0.0) -> dict[str, Boxes3D]:
        """Boxes by scenario."""
        ...

    def measurements(self, **where: Any) -> list[Measurement]:
        """Other numbers; NaN where there is none."""
        ...
