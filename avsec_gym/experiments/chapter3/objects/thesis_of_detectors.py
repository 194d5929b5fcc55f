"""Figures of the thesis' chapter 3 on what attacks do to detectors; rates as fractions."""

from __future__ import annotations

from avsec_gym.experiments.chapter3.objects.attack_sizes import CAMERA, RADII, WIDTHS
from avsec_gym.sensor_system import LIDAR

TAKEN_FOR_AN_OBSTACLE = 986 / 1000
"""Bogus returns, by PIXOR (section 3.2.4)."""
FACULA_PRECISION = (0.8462, 0.6153)
"""AP of cars by Faster R-CNN at IoU 0.5, clean and under a facula (section 3.2.4)."""
PRECISION_OF_SIZE = {(CAMERA, RADII[4]): 0.5412}
"""AP of YOLOv3 at IoU 0.7 (section 3.5); the other sizes are curves without figures."""
IN_WORDS = {
    LIDAR: f"The thesis: detection nearly 100 % at {WIDTHS[2]:g} m, where PointRCNN’s AP has fallen"
    " by 0.06 in all.",
    CAMERA: f"The thesis: detection over 90 % at {RADII[4]:g} px (23.71 % of the image), small from"
    " 5 to 15 %.",
}
"""What the thesis states of the curves."""
