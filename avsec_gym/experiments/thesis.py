"""Figures of the thesis, to stand beside ours (section 5.4; rates as fractions)."""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.planners.planner import Algorithm
from avsec_gym.scenario.intention import Intention

NAMES = {"dsgn": "DSGN", "stereo_rcnn": "Stereo R-CNN"}
"""Names of the detectors."""

SAFE_DRIVING_WITH_GROUND_TRUTH = {
    (Algorithm.ASTAR, Intention.LEFT): 0.897,
    (Algorithm.ASTAR, Intention.STRAIGHT): 0.980,
    (Algorithm.ASTAR, Intention.RIGHT): 0.852,
    (Algorithm.GBFS, Intention.LEFT): 0.879,
    (Algorithm.GBFS, Intention.STRAIGHT): 0.980,
    (Algorithm.GBFS, Intention.RIGHT): 0.823,
}
"""Safe driving rate when the planner gets the ground truth."""


@dataclass(frozen=True)
class ThesisRates:
    """A row of the thesis' driving-safety tables."""

    success: float
    collision: float
    safe: float


# By detector and setting: success, collision and safe driving rate, each left, straight, right, %.
_SAFETY = """
dsgn         unattacked       89.6 96.5 84.4   2.2  0.7  1.7  87.7 95.8 83.0
dsgn         thesis_pgd-0.4-1 89.6 96.7 84.2   2.2  0.7  2.3  87.7 96.0 82.2
dsgn         thesis_pgd-0.4-2 89.5 96.7 84.4   2.4  0.7  2.7  87.3 96.0 82.0
dsgn         thesis_pgd-0.4-3 89.3 96.7 84.6   2.6  0.9  3.6  86.9 95.8 81.5
dsgn         thesis_pgd-0.4-4 89.5 96.9 84.8   2.8  1.1  3.8  86.9 95.8 81.5
dsgn         thesis_pgd-1-1   90.0 96.7 84.4   2.6  0.7  3.2  87.7 96.0 81.7
dsgn         thesis_pgd-1-2   89.3 96.5 84.4   2.8  0.9  3.8  86.7 95.6 81.1
dsgn         thesis_pgd-1-3   89.8 96.5 84.6   3.4  1.3  5.3  86.7 92.9 80.1
dsgn         thesis_pgd-1-4   89.5 96.9 84.8   3.4  1.3  5.9  86.4 95.6 79.7
dsgn         patch-random     90.0 96.5 84.6   2.6  0.7  2.3  87.7 95.8 82.6
dsgn         patch-specific   90.0 96.7 84.8   2.8  0.9  2.1  87.5 95.8 83.0
stereo_rcnn  unattacked       89.8 96.4 84.9   3.1  1.1  3.3  87.0 95.3 82.1
stereo_rcnn  thesis_pgd-0.4-1 89.8 96.0 85.3   2.7  1.1  3.5  87.4 94.9 82.3
stereo_rcnn  thesis_pgd-0.4-2 90.4 95.1 84.4   3.7  0.9  3.5  87.0 94.1 81.4
stereo_rcnn  thesis_pgd-0.4-3 90.0 95.1 85.9   4.1  1.3  5.4  86.3 93.8 81.2
stereo_rcnn  thesis_pgd-0.4-4 88.8 94.5 85.2   3.7  1.7  7.2  85.4 92.9 79.1
stereo_rcnn  thesis_pgd-1-1   90.2 95.8 85.7   3.3  1.5  4.1  87.2 94.3 82.1
stereo_rcnn  thesis_pgd-1-2   88.4 94.2 85.1   3.2  1.2  5.1  85.5 93.1 80.7
stereo_rcnn  thesis_pgd-1-3   89.8 95.5 86.7   4.7  2.1  8.6  85.5 93.4 79.2
stereo_rcnn  thesis_pgd-1-4   84.6 90.6 82.4   6.4  3.5 11.3  79.2 87.4 73.0
stereo_rcnn  patch-random     70.3 81.2 68.7   1.9  1.4  3.9  68.9 80.1 65.9
stereo_rcnn  patch-specific   83.7 57.5 74.4   2.1  4.7  4.2  81.9 54.7 71.2
"""

SAFETY = {
    (detector, setting, intention): ThesisRates(
        *(round(float(columns[3 * rate + place]) / 100, 3) for rate in range(3))
    )
    for line in _SAFETY.splitlines()
    if line
    for detector, setting, *columns in [line.split()]
    for place, intention in enumerate(Intention)
}
"""The rates by detector, setting (``thesis_pgd-0.4-3``: alpha 0.4, n 3) and intention; A*.

DSGN's safe driving rate for ``thesis_pgd-1-3`` straight is a slip of the source: it does not follow
from the other two."""

INTENTIONS = {
    "specific": ThesisRates(0.719, 0.035, 0.693),
    "same": ThesisRates(0.762, 0.023, 0.744),
    "different": ThesisRates(0.916, 0.015, 0.901),
    "unattacked": ThesisRates(0.904, 0.024, 0.881),
}
"""Stereo R-CNN under the patch, by whether attack and driving intention agree."""

LEVELS = ("easy", "moderate", "hard")

PRECISION = {
    ("dsgn", "unattacked"): (0.7094, 0.5298, 0.4729),
    ("dsgn", "thesis_pgd-0.4-1"): (0.2199, 0.1445, 0.1396),
    ("dsgn", "patch-random"): (0.6385, 0.4820, 0.4430),
    ("dsgn", "patch-specific-left"): (0.6572, 0.5147, 0.4680),
    ("dsgn", "patch-specific-straight"): (0.6496, 0.5077, 0.4615),
    ("dsgn", "patch-specific-right"): (0.6487, 0.5163, 0.4648),
    ("stereo_rcnn", "unattacked"): (0.5647, 0.3820, 0.3266),
    ("stereo_rcnn", "patch-random"): (0.5317, 0.3707, 0.3188),
    ("stereo_rcnn", "patch-specific-left"): (0.4814, 0.3627, 0.3121),
    ("stereo_rcnn", "patch-specific-straight"): (0.4782, 0.3523, 0.3060),
    ("stereo_rcnn", "patch-specific-right"): (0.5007, 0.3802, 0.3245),
}
"""Average precision of cars in 3D at IoU 0.7 by detector and setting; see `LEVELS`."""
