"""Procedural data sets on disk, in KITTI's layouts: made, resumed, verified, kept in the cache."""

from avsec_gym.world.capture import Sweep
from avsec_gym.world.export.connected import Connection
from avsec_gym.world.export.connected_world import ConnectedWorld, VehicleView
from avsec_gym.world.export.data_set import DataSetReport, make_data_set
from avsec_gym.world.export.default_suites import (
    default_suite,
    world_drives,
    world_frames,
    world_instants,
)
from avsec_gym.world.export.instants import ConnectedInstant, SensorVehicle, WorldObject
from avsec_gym.world.export.manifest import changed_files, read_manifest
from avsec_gym.world.export.recipe import Recipe, Sensors
from avsec_gym.world.export.suites import SUITES, suite_recipe
from avsec_gym.world.export.twins import Twins

__all__ = [
    "SUITES",
    "ConnectedInstant",
    "ConnectedWorld",
    "Connection",
    "DataSetReport",
    "Recipe",
    "SensorVehicle",
    "Sensors",
    "Sweep",
    "Twins",
    "VehicleView",
    "WorldObject",
    "changed_files",
    "default_suite",
    "make_data_set",
    "read_manifest",
    "suite_recipe",
    "world_drives",
    "world_frames",
    "world_instants",
]
