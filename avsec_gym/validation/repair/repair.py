"""A frame without its damage, filled from the trusted sensors (thesis, section 6.2: future work).

What is filled is no measurement of the attacked sensor: it repeats what others saw, and where no
other saw it, it is inpainted from what is around.  `Repair` states which is which.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, Image, Points, SensorFrame
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem
from avsec_gym.validation.evidence.brightness import equally_exposed
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.reprojection import Mask
from avsec_gym.validation.repair.damaged_scan import (
    DamagedScan,
    TrustedMaps,
    bogus_points,
    directions,
    lost_directions,
    seen_places,
    trusted_maps,
)
from avsec_gym.validation.repair.localisation import contradicting_pixels
from avsec_gym.validation.repair.trusted_view import TrustedView, trusted_view

REFILLED_REFLECTANCE = 0.0
"""Cameras do not know it."""
_INPAINTED_FROM = 3.0
"""Pixels around what is made up."""
_BEAM_ROWS = 2
"""Directions between two rings of a LiDAR."""
REFILL_ERROR = 1.0
"""Metres of depth that a pixel of disparity may be where a scan is refilled.  Points that are
farther off cost a detector of scans more cars than nearer ones, which show what stands there."""


@dataclass(frozen=True, eq=False)
class Repair:
    """A repaired frame.

    Args:
        frame: The frame to be used in place of the tampered one.
        pixels: Pixels of each attacked camera: what was found damaged and filled, shape (H, W).
        made_up: The part of that, for each attacked camera, which no trusted camera saw.
        scan: What was found wrong with the tampered scan; None: the LiDAR is trusted.
        refilled: Whether each point of the repaired scan is the cameras', shape (M,).
    """

    frame: SensorFrame
    pixels: Mapping[int, Mask] = field(default_factory=dict)
    made_up: Mapping[int, Mask] = field(default_factory=dict)
    scan: DamagedScan | None = None
    refilled: NDArray[np.bool_] | None = None


def repair(
    frame: SensorFrame,
    system: SensorSystem,
    attacked: Iterable[Sensor],
    depth: PairDepth | None = None,
    refill_error: float = REFILL_ERROR,
) -> Repair:
    """Find the damage in the sensors that are named, and fill it from the others.

    Args:
        frame: The tampered frame.
        system: The sensors of which some are trusted.
        attacked: The sensors that are not trusted.
        depth: How the disparities of two trusted cameras are found.
        refill_error: Metres of depth that a pixel of disparity may be, see `refilled_points`.

    Raises:
        ConfigurationError: An attacked sensor is not in the system, or too few are trusted: two
            cameras, or for the repair of a camera one and the LiDAR; or a negative `refill_error`.
        DataError: The frame lacks a sensor, or its file is broken.
    """
    if not refill_error >= 0:
        raise ConfigurationError(f"refill_error is 0 or more metres, got {refill_error:g}")
    named = set(attacked)
    if unknown := named - set(system.sensors):
        raise ConfigurationError(f"no sensors of the system: {sorted(unknown, key=str)}")
    # Cameras first: each is painted from the trusted sensors alone, so that the order is free.
    trusted = tuple(sensor for sensor in system.sensors if sensor not in named)
    repaired, pixels, made_up = frame, {}, {}
    for camera in (sensor for sensor in system.cameras if sensor in named):
        view = trusted_view(frame, camera, trusted, depth)
        found = contradicting_pixels(frame.image(camera), view)
        repaired = repaired.with_image(camera, filled_image(frame.image(camera), view, found))
        pixels[camera], made_up[camera] = found, found & ~view.believed
    if LIDAR not in named:
        return Repair(repaired, pixels, made_up)
    # The scan: bogus points are removed, then lost directions are refilled from the cameras.
    maps = trusted_maps(frame, trusted, depth)
    nearest = (depth or PairDepth()).nearest
    bogus = bogus_points(frame.points, frame.calibration, maps, nearest)
    sound = frame.points[~bogus]
    scan = DamagedScan(bogus, lost_directions(sound, frame.calibration, maps))
    seen = refilled_points(scan, frame.calibration, maps, refill_error)
    refilled = np.arange(len(sound) + len(seen)) >= len(sound)
    repaired = repaired.with_points(np.concatenate([sound, seen]))
    return Repair(repaired, pixels, made_up, scan, refilled)


def filled_image(image: Image, view: TrustedView, damaged: Mask) -> Image:
    """An image whose damaged pixels are painted as trusted cameras see them.

    What none of them sees is continued from around (Telea's inpainting).

    Args:
        image: The image of the attacked camera.
        view: The image that the camera should see.
        damaged: The pixels to fill, shape (H, W).
    """
    result = np.where(
        (damaged & view.believed)[..., None],
        equally_exposed(view.image, image, view.believed).least,
        image,
    )
    unseen = damaged & ~view.believed
    if not unseen.any():
        return result
    return np.asarray(
        cv2.inpaint(result, unseen.astype(np.uint8), _INPAINTED_FROM, cv2.INPAINT_TELEA), np.uint8
    )


def refilled_points(
    scan: DamagedScan,
    calibration: Calibration,
    maps: TrustedMaps,
    refill_error: float = REFILL_ERROR,
) -> Points:
    """Points of trusted maps in the directions without returns, about as dense as a LiDAR's.

    Of the places in a beam's direction the middle one in distance.  The widest pair's map is used;
    where it has a hole, nothing is refilled.

    Args:
        scan: What is lost.
        calibration: The calibration of the rig.
        maps: The trusted maps, see `trusted_maps`.
        refill_error: Metres of depth that a pixel of disparity is at most where points are made: 1
            m reaches 20 m with a baseline of 0.54 m and KITTI's focal length.

    Returns:
        Shape (N, 4), reflectance `REFILLED_REFLECTANCE`.
    """
    camera, trusted = next(iter(maps.items()))
    reach = np.sqrt(refill_error * trusted.focal_times_baseline)
    places = seen_places(trusted, calibration, camera, reach)
    row, column, inside = directions(places)
    inside &= scan.lost[row, column]
    places = places[inside]
    beam = row[inside] // _BEAM_ROWS * scan.lost.shape[1] + column[inside]
    order = np.lexsort((np.linalg.norm(places, axis=1), beam))
    _, first, count = np.unique(beam[order], return_index=True, return_counts=True)
    chosen = places[order[first + count // 2]]
    return np.c_[chosen, np.full(len(chosen), REFILLED_REFLECTANCE)].astype(np.float32)
