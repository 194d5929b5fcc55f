"""Instants of connected vehicles, from the data set in which they were recorded."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.sweep import RollingSweep
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from avsec_gym.world.export import ConnectedInstant, ConnectedWorld, sweep_of

Poses = Literal["measured", "true"]
"""The poses that align the scans: those that the vehicles measure, or the true ones."""


@dataclass(frozen=True, eq=False)
class RecordedInstant:
    """What all vehicles scanned at an instant.

    Args:
        id: The name of the instant in its data set.
        scans: The scan of each vehicle, by number.
        truth: What was really there; None of a recording without labels.
        true_poses: The true pose of each vehicle's velodyne, shape (4, 4) each; empty where they
            are not known, and those of the scans are the best that there is.
    """

    id: str
    scans: tuple[VehicleScan, ...]
    truth: ConnectedInstant | None = None
    true_poses: tuple[Floats, ...] = ()

    def true_pose(self, vehicle: int) -> Floats:
        """Where a vehicle's velodyne is, as well as that is known, shape (4, 4)."""
        return self.true_poses[vehicle] if self.true_poses else self.scans[vehicle].pose


def recorded_instants(
    world: ConnectedWorld, poses: Poses = "measured", ids: Sequence[str] | None = None
) -> Iterator[RecordedInstant]:
    """The instants of a data set of connected vehicles, one after the other.

    Args:
        world: The data set.
        poses: The poses that align the scans, true or measured ones.
        ids: The instants that are read; None: all.

    Raises:
        ConfigurationError: There are no such poses.
        DataError: Something of an instant is missing or broken.

    Example:
        >>> world = ConnectedWorld("data/connected")  # doctest: +SKIP
        >>> [len(instant.scans) for instant in recorded_instants(world)]  # doctest: +SKIP
    """
    if poses not in ("measured", "true"):
        raise ConfigurationError(f"poses are 'measured' or 'true', got {poses!r}")
    for id in world.ids() if ids is None else ids:
        truth = world.instant(id)
        views = world.views(id)
        scans = tuple(
            VehicleScan(
                view.frame.points,
                view.measured_pose if poses == "measured" else view.pose,
                view.time,
                RollingSweep(*sweep_of(vehicle, world.sweep)),
                vehicle.is_roadside,
            )
            for view, vehicle in zip(views, truth.vehicles, strict=True)
        )
        yield RecordedInstant(id, scans, truth, tuple(view.pose for view in views))
