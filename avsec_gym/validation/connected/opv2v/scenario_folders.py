"""Instants of connected vehicles from OPV2V-style folders.

``ROOT/2021_08_22_21_41_24/1732/00000.yaml`` and ``00000.pcd``: a scenario, a vehicle, an instant.
https://opencood.readthedocs.io/en/latest/md_files/data_intro.html describes them; camera images are
not looked at.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats
from avsec_gym.storage.regular_files import is_folder
from avsec_gym.validation.connected.opv2v.annotations import connected_truth
from avsec_gym.validation.connected.opv2v.carla_frames import (
    carla_transform,
    velodyne_points,
    velodyne_pose,
)
from avsec_gym.validation.connected.opv2v.pcd_files import read_pcd
from avsec_gym.validation.connected.opv2v.yaml_nodes import YamlMapping, read_yaml_mapping
from avsec_gym.validation.connected.recordings import Poses, RecordedInstant
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

FARTHEST_POSE = 1e5
"""Metres from the origin of CARLA's world; its largest town has 4 km."""
MOST_ANGLE = 720.0
"""The largest angle that a file may have, degrees."""
_VEHICLE = re.compile(r"-?[0-9]{1,9}")
_INSTANT = re.compile(r"[0-9]{1,9}")
_REMEDY = "Name a scenario such as 2021_08_22_21_41_24, or a folder of scenarios such as `train`."


@dataclass(frozen=True)
class Opv2vScenario:
    """The folder of one scenario.

    Args:
        folder: The path of the folder.
        number: The scenario's number among those of its data set.
    """

    folder: Path
    number: int = 0

    def vehicles(self) -> list[str]:
        """The names of its vehicles (with V2XSet's roadside sensors, negative), by number."""
        return sorted(_names(self.folder, _VEHICLE, folders=True), key=int)

    def instants(self) -> list[str]:
        """The instants of which every vehicle has both files, in order."""
        having = [
            _names(self.folder / vehicle, _INSTANT, suffix)
            for vehicle in self.vehicles()
            for suffix in (".yaml", ".pcd")
        ]
        return sorted(set.intersection(*having), key=int) if having else []


def find_scenarios(root: str | Path) -> list[Opv2vScenario]:
    """The scenarios in a folder, which may be one itself.

    Raises:
        DataError: There are none.
    """
    root = Path(root)
    if Opv2vScenario(root).vehicles():
        return [Opv2vScenario(root)]
    inside = sorted(root.iterdir()) if is_folder(root) else []
    found = [each for each in inside if is_folder(each) and Opv2vScenario(each).vehicles()]
    if not found:
        raise DataError(
            "There is no scenario of connected vehicles here.", path=root, remedy=_REMEDY
        )
    return [Opv2vScenario(folder, number) for number, folder in enumerate(found)]


def opv2v_instants(scenario: Opv2vScenario, poses: Poses = "true") -> Iterator[RecordedInstant]:
    """The instants of a scenario, one after the other.

    CARLA's scans are of one instant: `Sweep(0, 0, 0)` is theirs.

    Args:
        scenario: The scenario.
        poses: The poses that align the scans: those that the simulator knew (``lidar_pose``), or
            these moved as the vehicle misjudged its own (``predicted_ego_pos``).

    Raises:
        ConfigurationError: There are no such poses.
        DataError: Fewer than two vehicles, no instant, or a file that is missing or broken.
    """
    if poses not in ("measured", "true"):
        raise ConfigurationError(f"poses are 'measured' or 'true', got {poses!r}")
    vehicles, instants = scenario.vehicles(), scenario.instants()
    if len(vehicles) < 2 or not instants:
        raise DataError(
            f"There are {len(vehicles)} vehicles with {len(instants)} common instants; two with one"
            " or more are needed.",
            path=scenario.folder,
            remedy=_REMEDY,
        )
    for frame, name in enumerate(instants):
        places = [scenario.folder / vehicle / name for vehicle in vehicles]
        files = [read_yaml_mapping(place.with_suffix(".yaml")) for place in places]
        scans = tuple(
            VehicleScan(
                velodyne_points(read_pcd(place.with_suffix(".pcd"))),
                _lidar_pose(file, poses),
                # V2XSet numbers roadside sensors below zero.
                roadside=int(place.parent.name) < 0,
            )
            for place, file in zip(places, files, strict=True)
        )
        true_scans = tuple(
            VehicleScan(scan.points, _lidar_pose(file, "true"))
            for scan, file in zip(scans, files, strict=True)
        )
        truth = connected_truth(
            scenario.number, frame, [int(vehicle) for vehicle in vehicles], files, true_scans
        )
        yield RecordedInstant(
            f"{scenario.folder.name}/{name}", scans, truth, tuple(scan.pose for scan in true_scans)
        )


def _lidar_pose(file: YamlMapping, poses: Poses) -> Floats:
    """The pose of the velodyne frame in our world, shape (4, 4)."""
    lidar = carla_transform(_pose(file, "lidar_pose"))
    if poses == "measured":
        true, predicted = _pose(file, "true_ego_pos"), _pose(file, "predicted_ego_pos")
        lidar = carla_transform(predicted) @ np.linalg.inv(carla_transform(true)) @ lidar
    return velodyne_pose(lidar)


def _pose(file: YamlMapping, key: str) -> Floats:
    numbers = np.array(file.numbers(key, 6, FARTHEST_POSE))
    if np.abs(numbers[3:]).max() > MOST_ANGLE:
        raise file.broken(key, "An angle of a pose is more than two turns.")
    return numbers


def _names(
    folder: Path, pattern: re.Pattern[str], suffix: str = "", *, folders: bool = False
) -> set[str]:
    """The names in a folder, without their suffix; none where it is no folder."""
    children = folder.iterdir() if is_folder(folder) else iter(())
    return {
        child.name.removesuffix(suffix)
        for child in children
        if child.name.endswith(suffix)
        and pattern.fullmatch(child.name.removesuffix(suffix))
        and (not folders or is_folder(child))
    }
