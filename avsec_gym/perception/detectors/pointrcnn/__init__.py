"""PointRCNN (Shi, Wang and Li, CVPR 2019): proposals from a LiDAR's points, then refined boxes."""
