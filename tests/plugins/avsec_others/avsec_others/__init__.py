"""Parts of another package: a detector, two attacks, a planner, a validator and an experiment."""

from avsec_gym import register


def load() -> None:
    """Give the parts their names; the entry point in pyproject.toml names this function."""
    from avsec_others.lane_change import LaneChange
    from avsec_others.shifted_image import ShiftedImage
    from avsec_others.stereo_and_scan import StereoAndScan
    from avsec_others.stereo_clusters import StereoClusters
    from avsec_others.worst_shift import WorstShift

    register("detector", "stereo_clusters", StereoClusters)
    register("optical_attack", "shifted_image", ShiftedImage)
    register("attack", "worst_shift", WorstShift)
    register("planner", "lane_change", LaneChange)
    register("validator", "stereo_and_scan", StereoAndScan)
