"""Several connected vehicles at the same instants: an object layout for each."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.storage.text_files import write_text
from avsec_gym.world.capture import render
from avsec_gym.world.drives import drive_scenes
from avsec_gym.world.export.frame_files import write_object_files
from avsec_gym.world.export.recipe import Sensors, whole_number


@dataclass(frozen=True, eq=False)
class ConnectedVehicles:
    """Instants, each at a place of its own; equal ids of ``vehicle_0``, ... are one instant.

    Args:
        count: Number of instants.
        seed: Seed of the set.
        sensors: The sensors of every vehicle.
        vehicles: Number of vehicles, 2 or more.

    Raises:
        ConfigurationError: Fewer vehicles.
    """

    count: int
    seed: int = 0
    sensors: Sensors = field(default_factory=Sensors)
    vehicles: int = 3

    def __post_init__(self) -> None:
        whole_number("the number of connected vehicles", self.vehicles, 2)

    @property
    def settings(self) -> dict[str, Any]:
        """See `Recipe`."""
        return {
            "suite": "connected",
            "seed": self.seed,
            "vehicles": self.vehicles,
            **self.sensors.to_json(self._cameras),
        }

    @property
    def last_files(self) -> str:
        """See `Recipe`."""
        return f"vehicle_{self.vehicles - 1}/training/label_2/*.txt"

    def __len__(self) -> int:
        return self.count

    def last_file(self, number: int) -> str:
        """See `Recipe`: of the last vehicle."""
        return f"vehicle_{self.vehicles - 1}/training/label_2/{number:06d}.txt"

    def make(self, root: Path, number: int) -> list[str]:
        """See `Recipe`."""
        posed = drive_scenes(self.seed, number, 1, self.vehicles, self.sensors.rig)[0]
        actors = posed.instant.actors
        for vehicle, own in enumerate(posed.instant.egos):
            folder, id = root / f"vehicle_{vehicle}" / "training", f"{number:06d}"
            pose = posed.vehicle_to_world[vehicle] @ posed.rig.velodyne_pose
            words = " ".join(repr(value) for value in np.round(pose[:3], 9).ravel().tolist())
            write_text(folder / "pose" / f"{id}.txt", words + "\n", overwrite=True)
            write_object_files(
                folder,
                id,
                posed,
                render(posed, ego=vehicle, cameras=self._cameras, lidar=self.sensors.scanner),
                notes={
                    "actor": int(actors.id[own]),
                    "ego_speed": round(float(actors.speed[own]), 3),
                },
            )
        return []

    def finish(self, root: Path) -> None:
        """See `Recipe`: there is nothing to do."""

    @property
    def _cameras(self) -> tuple[int, ...]:
        return self.sensors.or_usual(2, 3)
