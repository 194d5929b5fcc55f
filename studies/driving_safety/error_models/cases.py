"""Which detectors, attacks and drives the shipped error models are of."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avsec_gym.attacks.patch_files import shipped_patch
from avsec_gym.kitti.dataset import KittiObject

DETECTORS = ("stereo_rcnn", "dsgn")
FIT, CHECK = "fit", "check"
"""Data sets of connected vehicles: what models are fitted to, and what they are held against."""
VEHICLES = (0, 1)
DEAR_VEHICLES = (0,)
"""Vehicles whose frames are attacked by gradients, which takes ten times as long."""
DEAREST, DEAREST_SHARE = "dsgn", 0.5
"""The slowest detector, and in what share of the drives that it is fitted to, the first ones,
gradients attack it."""


@dataclass(frozen=True)
class Case:
    """A detector, left alone or under an attack.

    Args:
        detector: The detector's name.
        attack: The name of the attack in the error model's name; empty: none.
        arguments: The attack as the registry takes it, a shipped patch by its name; None: none.
        vehicles: The vehicles whose frames it sees.
        share: Share of the frames of `FIT`, the first ones, that it sees; of `CHECK` it sees all.
    """

    detector: str
    attack: str
    arguments: dict[str, Any] | None
    vehicles: tuple[int, ...]
    share: float = 1.0

    @property
    def name(self) -> str:
        """The name of the error model."""
        return f"{self.detector}_{self.attack}" if self.attack else self.detector

    @property
    def asked(self) -> Any:
        """The detector as the registry takes it, seeing through the attack."""
        if self.arguments is None:
            return self.detector
        attack = dict(self.arguments)
        if "patch" in attack:
            attack["patch"] = str(shipped_patch(attack["patch"]))
        return {"name": "attacked", "detector": self.detector, "attack": attack, "seed": 0}

    def ids(self, kitti: Path) -> list[str]:
        """The frames of a vehicle that it sees.

        Args:
            kitti: The vehicle's folder.
        """
        every = KittiObject(kitti).ids(having=("label_2",))
        return every[: round(self.share * len(every))] if kitti.parent.name == FIT else every

    def folders(self, runs: Path, of: str) -> Iterator[tuple[Path, Path]]:
        """Labelled frames, and the case's detections in them: a pair for each vehicle.

        Args:
            runs: The folder of the study.
            of: `FIT` or `CHECK`.
        """
        for vehicle in self.vehicles:
            yield (
                runs / of / f"vehicle_{vehicle}",
                runs / "detections" / self.name / f"{of}_{vehicle}",
            )


def cases() -> Iterator[Case]:
    """All cases, the quickest first."""
    for detector in DETECTORS:
        yield Case(detector, "", None, VEHICLES)
        yield Case(detector, "patch", {"name": "patch", "patch": detector}, VEHICLES)
    for detector in DETECTORS:
        share = DEAREST_SHARE if detector == DEAREST else 1.0
        yield Case(detector, "thesis_pgd", {"name": "thesis_pgd"}, DEAR_VEHICLES, share)
