"""KITTI's files in their official layouts: read where the user has them, written by their rules."""

from avsec_gym.kitti.calibration import read_calibration, write_calibration
from avsec_gym.kitti.check import check_data
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.kitti.detections import DetectionFolder, above, default_score_threshold
from avsec_gym.kitti.label_folders import read_label_folder
from avsec_gym.kitti.labels import read_detections, read_labels, write_detections, write_labels
from avsec_gym.kitti.map_files import read_disparity, read_mask, write_disparity, write_mask
from avsec_gym.kitti.odometry import KittiOdometry, OdometrySequence
from avsec_gym.kitti.oxts import Oxts, read_oxts, write_oxts
from avsec_gym.kitti.oxts_poses import oxts_from_poses, poses_from_oxts
from avsec_gym.kitti.raw import Drive, KittiRaw
from avsec_gym.kitti.raw_calibration import read_raw_calibration, write_raw_calibration
from avsec_gym.kitti.report import DataReport
from avsec_gym.kitti.sensor_files import (
    read_image,
    read_image_size,
    read_points,
    write_image,
    write_points,
)
from avsec_gym.kitti.splits import RawOrigin, read_raw_mapping, read_split
from avsec_gym.kitti.stereo import KittiStereo
from avsec_gym.kitti.timestamps import read_timestamps, write_timestamps
from avsec_gym.kitti.tracking import TrackedBoxes, read_tracking_labels
from avsec_gym.kitti.tracking_sequences import KittiTracking, TrackingSequence
from avsec_gym.kitti.tracklets import Tracklet, read_tracklets, tracklet_boxes, write_tracklets
from avsec_gym.kitti.writing import write_drive_records, write_object_frame, write_raw_frame

__all__ = [
    "DataReport",
    "DetectionFolder",
    "Drive",
    "KittiObject",
    "KittiOdometry",
    "KittiRaw",
    "KittiStereo",
    "KittiTracking",
    "OdometrySequence",
    "Oxts",
    "RawOrigin",
    "TrackedBoxes",
    "TrackingSequence",
    "Tracklet",
    "above",
    "check_data",
    "default_score_threshold",
    "oxts_from_poses",
    "poses_from_oxts",
    "read_calibration",
    "read_detections",
    "read_disparity",
    "read_image",
    "read_image_size",
    "read_label_folder",
    "read_labels",
    "read_mask",
    "read_oxts",
    "read_points",
    "read_raw_calibration",
    "read_raw_mapping",
    "read_split",
    "read_timestamps",
    "read_tracking_labels",
    "read_tracklets",
    "tracklet_boxes",
    "write_calibration",
    "write_detections",
    "write_disparity",
    "write_drive_records",
    "write_image",
    "write_labels",
    "write_mask",
    "write_object_frame",
    "write_oxts",
    "write_points",
    "write_raw_calibration",
    "write_raw_frame",
    "write_timestamps",
    "write_tracklets",
]
