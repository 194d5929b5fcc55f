"""How well damage is located and repaired; the true area judges, the repair knows nothing of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import OpticalAttack, TamperedFrame
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.validation.repair.repair import Repair

RADII = (37.5, 112.5, 225.0, 375.0)
"""Radii of faculae, pixels."""
WIDTHS = (0.5, 1.5, 2.5)
"""Widths of bogus returns, metres."""
CAR = "pasted car, rays lost"
"""An attack that needs a second frame: the pasted scan is from there."""
_FOUND = 0.5
"""Least IoU of two 2D boxes of one object."""


@dataclass(frozen=True)
class Overlap:
    """A found area beside the true one; None where it is a share of nothing.

    Args:
        iou: Intersection over union.
        precision: Share of the found area that is true.
        recall: Share of the true area that is found.
    """

    iou: float | None
    precision: float | None
    recall: float | None


def attacks_of(camera: int = 2) -> dict[str, OpticalAttack]:
    """The attacks that are tried, by their names.

    Args:
        camera: The camera that light shines into, and in whose view bogus returns are.
    """
    result: dict[str, OpticalAttack] = {
        f"facula, camera {camera}, {radius:g} px": Facula(camera, radius) for radius in RADII
    }
    for lost in (False, True):
        for width in WIDTHS:
            name = f"bogus return, {width:g} m" + (", rays lost" if lost else "")
            result[name] = LidarSpoofing(width=width, reference=camera, rays_lost=lost)
    return result


def measures_of(
    clean: SensorFrame, tampered: TamperedFrame, repaired: Repair
) -> dict[str, float | None]:
    """One attack on one sensor, located and repaired.

    Args:
        clean: The frame without an attack.
        tampered: The attacked frame, as the car gets it.
        repaired: The repaired frame.

    Returns:
        ``iou``, ``precision`` and ``recall`` of the found pixels or points, see `Overlap`.  Of a
        camera ``error_before`` and ``error_after``: mean difference to the clean image in the true
        area, grey levels, of the attacked and of the repaired image.  Of an attack that loses rays
        ``iou_of_lost``, of the clean scan's points.
    """
    for camera, true in tampered.pixels.items():
        image = clean.image(camera)
        return {
            **vars(overlap(repaired.pixels[camera], true)),
            "error_before": _difference(tampered.frame.image(camera), image, true),
            "error_after": _difference(repaired.frame.image(camera), image, true),
        }
    assert repaired.scan is not None, "what attacks no camera attacks the LiDAR"
    assert tampered.points is not None, "bogus returns are points"
    found: dict[str, float | None] = {**vars(overlap(repaired.scan.points, tampered.points))}
    if tampered.lost is not None:
        found["iou_of_lost"] = overlap(repaired.scan.is_lost(clean.points), tampered.lost).iou
    return found


def overlap(found: NDArray[np.bool_], true: NDArray[np.bool_]) -> Overlap:
    """Compare two areas, or two sets of points, of one shape."""
    both, either = int((found & true).sum()), int((found | true).sum())
    return Overlap(
        both / either if either else None,
        both / int(found.sum()) if found.any() else None,
        both / int(true.sum()) if true.any() else None,
    )


def found_again(objects: Boxes3D, detections: Boxes3D) -> int:
    """How many objects have a detection of their own: same category, IoU 0.5 or more in the image.

    Raises:
        ConfigurationError: The detector gives no boxes in the image.
    """
    if not len(objects) or not len(detections):
        return 0
    one, other = objects.box2d, detections.box2d
    if one is None or other is None:
        raise ConfigurationError(
            "objects are found again by their 2D boxes; the detector gives none: name stereo_rcnn"
        )
    low = np.maximum(one[:, None, :2], other[None, :, :2])
    high = np.minimum(one[:, None, 2:], other[None, :, 2:])
    common = np.prod(np.maximum(high - low, 0.0), axis=2)
    areas, others = (np.prod(box[:, 2:] - box[:, :2], axis=1) for box in (one, other))
    same = common >= _FOUND * (areas[:, None] + others[None, :] - common)
    same &= objects.category[:, None] == detections.category[None, :]
    return int(same[linear_sum_assignment(same, maximize=True)].sum())


def _difference(image: Image, clean: Image, area: NDArray[np.bool_]) -> float | None:
    if not area.any():
        return None
    return float(np.abs(image[area].astype(float) - clean[area]).mean())
