"""`ConnectedWorld`: the instants of connected vehicles, read back from a data set."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.connected_scans import ConnectedScans, ScanPose, SharedScan
from avsec_gym.errors import DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.label_folders import check_id, frame_ids
from avsec_gym.storage.plain_numbers import plain_number
from avsec_gym.storage.regular_files import is_file, is_folder, read_text
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.export.instants import (
    ConnectedInstant,
    SensorVehicle,
    read_instant,
    shared_objects,
)
from avsec_gym.world.export.manifest import MANIFEST, read_manifest

MEETINGS = "meetings.json"
"""Name of the file that states how much vehicles see of the same objects."""
_VEHICLE = re.compile(r"vehicle_([0-9]+)")
_PERIOD = 0.1
_POSE_BYTES = 4096
_FARTHEST = 3e7
"""Metres from the world's origin, which may lie anywhere on this earth."""
_RIGID = 1e-3
"""How far a rotation that was read may be from one: files of others have few digits."""
_REMEDY = "Name a data set of `avsec world make --suite connected`."
_COMPLETE = "`avsec world make` with the same arguments completes a data set."


@dataclass(frozen=True, eq=False)
class VehicleView:
    """What one vehicle measures at an instant, and where it is.

    Args:
        frame: The images and the scan.
        pose: True transform from the velodyne frame to the world at its own time, shape (4, 4).
        measured_pose: The same as the vehicle measures it, shape (4, 4).
        time: The time of its clock after the instant, seconds.
    """

    frame: SensorFrame
    pose: Floats
    measured_pose: Floats
    time: float


class ConnectedWorld:
    """A data set of connected vehicles.

    Args:
        root: The folder, which holds ``objects``, ``vehicle_0``, ``vehicle_1``, ...

    Raises:
        DataError: It is none.

    Example:
        >>> world = ConnectedWorld("data/connected")  # doctest: +SKIP
        >>> instant = world.instant("000000")  # doctest: +SKIP
        >>> [view.pose for view in world.views("000000")]  # doctest: +SKIP
    """

    def __init__(self, root: str | Path) -> None:
        self.root = Path(root)
        folders = sorted(self.root.glob("vehicle_*")) if is_folder(self.root) else []
        if not folders or not is_folder(self.root / "objects"):
            raise DataError("There are no connected vehicles here.", path=self.root, remedy=_REMEDY)
        self.vehicles = tuple(KittiObject(self.root / f"vehicle_{i}") for i in range(len(folders)))

    def ids(self) -> list[str]:
        """All instants, such as ``000000``, in order.

        Raises:
            DataError: A vehicle has a scan of an instant whose truth is missing.
        """
        listed = frame_ids(self.root / "objects", ".json")
        folders = [data.folder / "velodyne" for data in self.vehicles]
        scanned = {id for each in folders if is_folder(each) for id in frame_ids(each, ".bin")}
        if missing := sorted(scanned.difference(listed)):
            raise DataError(
                f"What is true at an instant is missing, of which there are scans; so it is of"
                f" {len(missing)} of {len(scanned)} instants.",
                path=self.root / "objects" / f"{missing[0]}.json",
                remedy=_COMPLETE,
            )
        return listed

    def check_complete(self) -> None:
        """Refuse a data set that lacks its manifest, or that was not made to its end.

        Raises:
            DataError: It is one of these.
        """
        if not self._manifest()["complete"]:
            raise DataError("The data set is not complete.", path=self.root, remedy=_COMPLETE)

    @property
    def sweep(self) -> str:
        """How its scans treat motion during a turn, a value of `avsec_gym.world.capture.Sweep`.

        Raises:
            DataError: There is no manifest.
        """
        return str(self._manifest()["settings"].get("sweep", "rolling"))

    def _manifest(self) -> dict[str, Any]:
        manifest = read_manifest(self.root)
        if manifest is None:
            raise DataError(
                "The manifest is missing, which states how the scans came about.",
                path=self.root / MANIFEST,
                remedy=_COMPLETE,
            )
        return manifest

    def drives(self) -> dict[int, list[str]]:
        """The instants of each drive, in order; single instants are drives of one."""
        result: dict[int, list[str]] = {}
        for id in self.ids():
            result.setdefault(self.instant(id).drive, []).append(id)
        return result

    def instant(self, id: str) -> ConnectedInstant:
        """What is true at an instant.

        Raises:
            DataError: There is no such instant, or its file is broken.
        """
        return read_instant(self.root / "objects" / f"{check_id(id)}.json")

    def views(self, id: str) -> list[VehicleView]:
        """What each vehicle measures at an instant.

        Raises:
            DataError: Something of it is missing or broken.
        """
        instant = self.instant(id)
        return [
            VehicleView(
                data.frame(id),
                read_pose(data.folder / "pose" / f"{id}.txt"),
                read_pose(data.folder / "measured_pose" / f"{id}.txt"),
                vehicle.time,
            )
            for data, vehicle in zip(self.vehicles, instant.vehicles, strict=True)
        ]


def sweep_of(vehicle: SensorVehicle, kind: str) -> tuple[float, float, float]:
    """How a scan came about: speed (m/s), turn rate (rad/s), and period of the turn (seconds).

    A vehicle's odometry is taken to be exact.

    Args:
        vehicle: The vehicle at the instant.
        kind: How scans treat motion, as `ConnectedWorld.sweep` has it.
    """
    if kind == "rolling":
        return vehicle.speed, vehicle.turn_rate, _PERIOD
    return 0.0, 0.0, _PERIOD if kind == "compensated" else 0.0


def neighbours_of(data: KittiObject, id: str) -> Callable[[], ConnectedScans] | None:
    """What the other vehicles of an instant share with one of them; None where there are none.

    Args:
        data: The frames of one of the vehicles: ``vehicle_0`` and so on of a data set of connected
            vehicles.  Of any other data there are no neighbours.
        id: The instant.
    """
    folder = data.folder.resolve().parent
    found = _VEHICLE.fullmatch(folder.name)
    if found is None or not is_file(folder.parent / "objects" / f"{check_id(id)}.json"):
        return None
    return partial(_neighbours, folder.parent, int(found[1]), id)


def _neighbours(root: Path, own: int, id: str) -> ConnectedScans:
    world = ConnectedWorld(root)
    views, vehicles = world.views(id), world.instant(id).vehicles
    places = [
        ScanPose(
            view.measured_pose, view.time, *sweep_of(vehicle, world.sweep), vehicle.is_roadside
        )
        for view, vehicle in zip(views, vehicles, strict=True)
    ]
    others = [
        SharedScan(lambda frame=view.frame: frame.points, place)  # type: ignore[misc]
        for number, (view, place) in enumerate(zip(views, places, strict=True))
        if number != own
    ]
    return ConnectedScans(places[own], tuple(others))


def read_pose(path: str | Path) -> Floats:
    """A pose of 12 numbers, row by row, as a transform of shape (4, 4).

    Raises:
        DataError: The file is missing, or holds something else than a rotation and a place on this
            earth.
    """
    words = read_text(path, most=_POSE_BYTES).split()
    try:
        numbers = np.array([plain_number(word) for word in words])
        if numbers.shape != (12,) or not np.isfinite(numbers).all():
            raise ValueError
    except ValueError:
        raise DataError("A pose has 12 finite numbers.", path=path, remedy=_REMEDY) from None
    pose = np.vstack([numbers.reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])
    if not _is_rotation(pose[:3, :3]) or np.abs(pose[:3, 3]).max() > _FARTHEST:
        raise DataError(
            f"A pose is a rotation and a place within {_FARTHEST:g} m.", path=path, remedy=_REMEDY
        )
    return pose


def _is_rotation(matrix: Floats) -> bool:
    """Whether a matrix of shape (3, 3) turns, and does nothing else."""
    if np.abs(matrix).max() > 1 + _RIGID:
        return False
    apart = np.abs(matrix @ matrix.T - np.eye(3)).max()
    return bool(apart <= _RIGID and np.linalg.det(matrix) > 0)


def write_meetings(root: Path, world: ConnectedWorld) -> None:
    """Write how much the vehicles of a data set see of the same objects.

    ``objects`` counts objects at instants that any vehicle sees (5 points or more), ``seen_by``
    those that 1, 2, ... vehicles see, and ``shared`` is the share that two or more see.
    """
    instants = [world.instant(id) for id in world.ids()]
    seen = [len(each.seen_by) for instant in instants for each in instant.objects]
    counts = [seen.count(number) for number in range(1, len(world.vehicles) + 1)]
    shared = shared_objects(instants)
    summary = {
        "instants": len(instants),
        "objects": sum(counts),
        "seen_by": counts,
        "shared": None if shared is None else round(shared, 4),
    }
    write_text(root / MEETINGS, json.dumps(summary, indent=1) + "\n", overwrite=True)
