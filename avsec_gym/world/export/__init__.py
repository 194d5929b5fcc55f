"""Procedural data sets on disk, in KITTI's layouts: made, resumed, verified, kept in the cache."""

from avsec_gym.world.capture import Sweep
from avsec_gym.world.export.connected import Connection
from avsec_gym.world.export.connected_world import (
    MEETINGS,
    ConnectedWorld,
    VehicleView,
    neighbours_of,
    sweep_of,
)
from avsec_gym.world.export.data_set import DataSetReport, make_data_set
from avsec_gym.world.export.default_suites import (
    cached,
    default_suite,
    world_drives,
    world_frames,
    world_instants,
)
from avsec_gym.world.export.frame_files import line_numbers
from avsec_gym.world.export.instants import (
    SEEN_POINTS,
    ConnectedInstant,
    SensorVehicle,
    WorldObject,
    instant_of,
)
from avsec_gym.world.export.manifest import (
    MANIFEST,
    changed_files,
    read_manifest,
    world_fingerprint,
)
from avsec_gym.world.export.measured_poses import clock_offsets, measured_pose, pose_errors
from avsec_gym.world.export.recipe import Recipe, Sensors
from avsec_gym.world.export.scene_file import actors_of, read_scene_file
from avsec_gym.world.export.suites import MOST_FRAMES, SUITES, LayoutFrames, suite_recipe
from avsec_gym.world.export.twins import Twins, twin_ids, twin_rig
from avsec_gym.world.textures.library import cache_folder

__all__ = [
    "MANIFEST",
    "MEETINGS",
    "MOST_FRAMES",
    "SEEN_POINTS",
    "SUITES",
    "ConnectedInstant",
    "ConnectedWorld",
    "Connection",
    "DataSetReport",
    "LayoutFrames",
    "Recipe",
    "SensorVehicle",
    "Sensors",
    "Sweep",
    "Twins",
    "VehicleView",
    "WorldObject",
    "actors_of",
    "cache_folder",
    "cached",
    "changed_files",
    "clock_offsets",
    "default_suite",
    "instant_of",
    "line_numbers",
    "make_data_set",
    "measured_pose",
    "neighbours_of",
    "pose_errors",
    "read_manifest",
    "read_scene_file",
    "suite_recipe",
    "sweep_of",
    "twin_ids",
    "twin_rig",
    "world_drives",
    "world_fingerprint",
    "world_frames",
    "world_instants",
]
