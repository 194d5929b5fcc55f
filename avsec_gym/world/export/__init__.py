"""Procedural data sets on disk, in KITTI's layouts: made, resumed, verified, kept in the cache."""

from avsec_gym.world.export.data_set import DataSetReport, make_data_set
from avsec_gym.world.export.default_suites import default_suite, world_drives, world_frames
from avsec_gym.world.export.manifest import changed_files, read_manifest
from avsec_gym.world.export.recipe import Recipe, Sensors
from avsec_gym.world.export.suites import SUITES, suite_recipe
from avsec_gym.world.export.twins import Twins

__all__ = [
    "SUITES",
    "DataSetReport",
    "Recipe",
    "Sensors",
    "Twins",
    "changed_files",
    "default_suite",
    "make_data_set",
    "read_manifest",
    "suite_recipe",
    "world_drives",
    "world_frames",
]
