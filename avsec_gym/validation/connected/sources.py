"""Where instants of connected vehicles are: this project's data sets, OPV2V folders, raw drives."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Literal

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.raw import Drive, KittiRaw
from avsec_gym.storage.regular_files import is_folder
from avsec_gym.validation.connected.opv2v.scenario_folders import find_scenarios, opv2v_instants
from avsec_gym.validation.connected.raw_drive.drive_instants import (
    DriveInstant,
    PosesBy,
    drive_instants,
)
from avsec_gym.validation.connected.recordings import Poses, RecordedInstant, recorded_instants
from avsec_gym.world.export import ConnectedWorld

PosesOf = Literal["measured", "true", "registration"]
"""The poses that align the scans; those of a raw drive are measured by oxts, or registered."""
Layout = Literal["connected", "opv2v", "kitti_raw"]
VEHICLES, APART = 3, 5
"""Scans of a raw drive that stand for vehicles at one instant, and the frames between them."""


@dataclass(frozen=True)
class ConnectedSource:
    """Instants of connected vehicles on disk.

    Args:
        root: The folder.
        layout: The layout of the folder.
        names: The instants' names where they are known without reading scans.
        instants: Function that yields the instants; see `read`.
    """

    root: Path
    layout: Layout
    names: tuple[str, ...]
    instants: Callable[[dict[str, str] | None], Iterator[RecordedInstant]]

    def read(self, left_out: dict[str, str] | None = None) -> Iterator[RecordedInstant]:
        """The instants, one after the other.

        Args:
            left_out: The dictionary that gets the reason for each raw drive without such scans, and
                for each of its instants that cannot be read or registered, by name; None: that is
                an error.

        Raises:
            DataError: Something of an instant is missing or broken.
        """
        return self.instants(left_out)

    def first(self, limit: int | None) -> ConnectedSource:
        """Only the first instants."""
        if limit is None:
            return self
        names = self.names[:limit]
        return ConnectedSource(
            self.root,
            self.layout,
            names,
            lambda left_out: islice(self.read(left_out), limit),
        )


def connected_source(root: str | Path, poses: PosesOf = "measured") -> ConnectedSource:
    """The instants of a folder, whichever of the three layouts it has.

    Args:
        root: A data set of `avsec world make --suite connected`; a scenario or a folder of
            scenarios in OPV2V's layout; a drive, a day or a folder of days in KITTI's raw layout.
        poses: The poses that align the scans, true or measured ones.

    Raises:
        ConfigurationError: Poses that this layout does not have.
        DataError: There is nothing of the kind, or a data set that lacks something.
    """
    root = Path(root)
    if not is_folder(root):
        raise DataError("There is no such folder.", path=root, remedy=_REMEDY)
    # What `avsec world make --suite connected` writes.
    if is_folder(root / "objects") and is_folder(root / "vehicle_0"):
        world, known = ConnectedWorld(root), _not_registered(poses)
        world.check_complete()
        return ConnectedSource(
            root, "connected", tuple(world.ids()), lambda _: recorded_instants(world, known)
        )
    # A raw drive: its frames, a distance apart, stand for vehicles.
    try:
        data = KittiRaw(root)
        drives = [data.drive(name) for name in data.drives()]
    except DataError:
        drives = []
    if drives:
        if poses == "true":
            raise ConfigurationError(
                "a raw drive has no true poses: 'measured' are those of its oxts, 'registration'"
                " registers its scans onto each other"
            )
        by: PosesBy = "registration" if poses == "registration" else "oxts"
        return ConnectedSource(root, "kitti_raw", (), lambda out: _of_drives(drives, by, out))
    # Scenarios in OPV2V's layout.
    try:
        scenarios = find_scenarios(root)
    except DataError as error:
        raise DataError(
            "There are no connected vehicles here.", path=root, remedy=_REMEDY
        ) from error
    known = _not_registered(poses)
    names = tuple(f"{each.folder.name}/{name}" for each in scenarios for name in each.instants())
    return ConnectedSource(
        root,
        "opv2v",
        names,
        lambda _: (instant for each in scenarios for instant in opv2v_instants(each, known)),
    )


def _of_drives(
    drives: Sequence[Drive], poses_by: PosesBy, left_out: dict[str, str] | None
) -> Iterator[DriveInstant]:
    """The instants of all drives; those without enough scans are left out, see `read`."""
    for drive in drives:
        try:
            yield from drive_instants(
                drive, vehicles=VEHICLES, apart=APART, poses_by=poses_by, left_out=left_out
            )
        except DataError as error:
            if left_out is None:
                raise
            left_out[drive.name] = str(error)


_REMEDY = (
    "Name a data set of `avsec world make --suite connected`, a folder in OPV2V's layout, or a"
    " drive in KITTI's raw layout."
)


def _not_registered(poses: PosesOf) -> Poses:
    if poses == "registration":
        raise ConfigurationError(
            "scans of different vehicles are not registered onto each other here, only those of a"
            " raw drive: poses are 'measured' or 'true'"
        )
    return poses
