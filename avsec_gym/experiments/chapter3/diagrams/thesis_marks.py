"""The thesis' own figures for the attacks of the diagrams, and whether ours hold them.

The thesis leaves density, depth and strength open.  Its figure lies where our interval holds it.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.experiments.chapter3.diagrams.evidence_cells import ATTACKED_CAMERAS
from avsec_gym.experiments.chapter3.diagrams.summary import RATE, SCENARIO
from avsec_gym.experiments.chapter3.diagrams.variant import Variant, is_of_lidar
from avsec_gym.experiments.chapter3.objects.thesis_of_detectors import TAKEN_FOR_AN_OBSTACLE
from avsec_gym.experiments.chapter3.thesis import DETECTION, IDENTIFICATION, OBJECT_LEVEL
from avsec_gym.metrics.clustered_shares import Share


def thesis_detected(variant: Variant) -> float | None:
    """Mean of its seven attack cases at r = 1 %; None: the thesis has no such attack."""
    return DETECTION[SCENARIO, RATE] if variant.of_thesis else None


def thesis_named(variant: Variant) -> float | None:
    """The thesis' rate of naming the LiDAR, or the attacked cameras, at r = 1 %; None likewise."""
    if not variant.of_thesis:
        return None
    positions = (0,) if is_of_lidar(variant) else ATTACKED_CAMERAS
    return float(np.mean([IDENTIFICATION[RATE][position] for position in positions]))


def thesis_believed(variant: Variant, detector: str) -> float | None:
    """Bogus returns that PIXOR takes for obstacles; None: another attack or detector."""
    return TAKEN_FOR_AN_OBSTACLE if variant.of_thesis and detector == "pixor" else None


def thesis_mismatched(variant: Variant | None, iou: float) -> float | None:
    """Mean of the seven attack cases that mismatches of objects reveal; None likewise."""
    return OBJECT_LEVEL[SCENARIO, iou] if variant is not None and variant.of_thesis else None


def holds(share: Share, thesis: float | None) -> bool:
    """Whether the interval of ours holds the thesis' figure.

    Example:
        >>> holds(Share.of_counts(96, 100), 0.9815), holds(Share.of_counts(40, 100), 0.9815)
        (True, False)
    """
    if thesis is None or share.interval is None:
        return False
    low, high = share.interval
    return low <= thesis <= high
