"""KITTI's files in their official layouts: read where the user has them, written by their rules."""

from avsec_gym.kitti.calibration import read_calibration, write_calibration
from avsec_gym.kitti.check import DataReport, check_object_root
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.detections import DetectionFolder, above, default_score_threshold
from avsec_gym.kitti.label_folders import read_label_folder
from avsec_gym.kitti.labels import read_detections, read_labels, write_detections, write_labels
from avsec_gym.kitti.sensor_files import read_image, read_image_size, read_points
from avsec_gym.kitti.splits import RawOrigin, read_raw_mapping, read_split

__all__ = [
    "DataReport",
    "DetectionFolder",
    "KittiObject",
    "RawOrigin",
    "above",
    "check_object_root",
    "default_score_threshold",
    "read_calibration",
    "read_detections",
    "read_image",
    "read_image_size",
    "read_label_folder",
    "read_labels",
    "read_points",
    "read_raw_mapping",
    "read_split",
    "write_calibration",
    "write_detections",
    "write_labels",
]
