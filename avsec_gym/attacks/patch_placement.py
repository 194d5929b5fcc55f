"""Where a patch stands: its place in both images, and which places there are in the world.

A patch is a poster that faces the car.  It can stand anywhere in the free space ahead: not so near
that no car looks so small there, not so far that its ghost would be in no car's way, not below the
ground, and not behind a real object that it covers in the image.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.argument_checks import number
from avsec_gym.attacks.argument_domains import DISTANCES, WIDTHS
from avsec_gym.attacks.attack import LEFT, RIGHT, Seed
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import box_corners, project
from avsec_gym.scenario.intention import Intention

RADIUS = 38.0
"""Pixels of images of 1242 x 375 (thesis, section 5.4.3)."""

_TILTS = (0.001, 180.0)
"""The tilts that may be asked for, degrees."""
_ROUNDING = 1e-6
"""Pixels, so that a patch at the very edge of what can be is still inside."""


@dataclass(frozen=True)
class PatchPlace:
    """A patch in a stereo pair: a disc in the left image, and how far away it is.

    Args:
        u: Column of its centre in the left image, pixels; ``u - disparity`` in the right one where
            the cameras differ by a shift along x alone, see `patch_views` for real ones.
        v: Row of its centre in the left image.
        disparity: Disparity f b / Z in pixels, with parts of pixels.
        rotation: Rotation about its centre, clockwise in the image, radians.
        radius: Radius of the disc, pixels.

    Raises:
        ConfigurationError: A value is not finite, or radius or disparity is not positive.
    """

    u: float
    v: float
    disparity: float
    rotation: float = 0.0
    radius: float = RADIUS

    def __post_init__(self) -> None:
        values = (self.u, self.v, self.disparity, self.rotation, self.radius)
        if not np.isfinite(values).all() or self.radius <= 0 or self.disparity <= 0:
            raise ConfigurationError(
                f"a patch has finite coordinates and a positive radius and disparity, got {self}"
            )

    def is_inside(self, height: int, width: int) -> bool:
        """Whether both images of such a size show all of it, if the right one is only shifted."""
        return (
            self.radius <= self.v <= height - 1 - self.radius
            and self.u <= width - 1 - self.radius
            and self.u - self.disparity >= self.radius
        )

    def intention(self, width: int) -> Intention:
        """The attack intention: the third of the left image that its centre is in."""
        third = int(np.clip((self.u + 0.5) * 3 / width, 0, 2))
        return (Intention.LEFT, Intention.STRAIGHT, Intention.RIGHT)[third]


@dataclass(frozen=True)
class PatchRange:
    """How far ahead a patch can stand, and how upright.

    Args:
        nearest: Least distance, metres.  A car whose rear a disc of `RADIUS` shows is 16 m away;
            the nearer, the more do size and disparity contradict each other for a stereo detector.
        farthest: Largest distance, metres.  A ghost that is well beyond the goal, 15 m ahead, stops
            no car.
        camera_height: Height of the camera above the ground, metres; the ground is assumed to be
            flat.
        tilt: Degrees by which it may be turned about its centre either way, as a poster that was
            hung up by hand.  A patch that has to work upside down as well can hardly look like
            anything.

    Raises:
        ConfigurationError: They are not positive, or not in order; a tilt beyond 180 degrees.
    """

    nearest: float = 8.0
    farthest: float = 20.0
    camera_height: float = 1.65
    tilt: float = 15.0

    def __post_init__(self) -> None:
        for name in ("nearest", "farthest"):
            number(name, getattr(self, name), *DISTANCES)
        number("camera_height", self.camera_height, *WIDTHS)
        number("tilt", self.tilt, *_TILTS)
        if self.nearest >= self.farthest:
            raise ConfigurationError(
                f"a patch stands in a range of distances, nearest below farthest, got {self}"
            )

    @property
    def steepest(self) -> float:
        """The largest rotation either way, radians."""
        return float(np.radians(self.tilt))

    def least_disparity(self, calibration: Calibration, lowest_row: float) -> float:
        """The least disparity of a patch whose lowest point is in this row."""
        projection = calibration.projection(LEFT)
        below_horizon = lowest_row - projection[1, 2]
        ground = projection[1, 1] * self.camera_height / max(below_horizon, 1e-9)
        return focal_times_baseline(calibration) / float(min(self.farthest, ground))

    def greatest_disparity(self, calibration: Calibration) -> float:
        """The disparity of the nearest patch."""
        return focal_times_baseline(calibration) / self.nearest


def random_place(
    calibration: Calibration,
    size: tuple[int, int],
    seed: Seed,
    *,
    radius: float = RADIUS,
    range: PatchRange = PatchRange(),
    objects: Boxes3D | None = None,
    intention: Intention | None = None,
) -> PatchPlace:
    """A place drawn from everywhere that both images show whole, of a random attack.

    Row, then column, then disparity are drawn uniformly from what is left to them.

    Args:
        calibration: Calibration of the cameras.
        size: Height and width of the images, pixels.
        seed: Seed of the draw.
        radius: Radius of the disc, pixels.
        range: Range of distances and tilts.
        objects: Real objects, see `disparities`.
        intention: Driving intention: only the third of the left image to which it points is used.

    Raises:
        ConfigurationError: The images have no room for such a patch.

    Example:
        >>> from avsec_gym.rig import kitti_rig
        >>> place = random_place(kitti_rig().calibration, (375, 1242), 7)
        >>> place.is_inside(375, 1242)
        True
    """
    height, width = size
    draw = np.random.default_rng(seed)
    projection = calibration.projection(LEFT)
    nearest_ground = projection[1, 2] + projection[1, 1] * range.camera_height / range.nearest
    v = _drawn(draw, radius, min(height - 1, nearest_ground) - radius, size, radius)
    least = range.least_disparity(calibration, v + radius)
    first, last = radius + least + _ROUNDING, width - 1 - radius
    if intention is not None:
        third = list(Intention).index(intention)
        first = max(first, third * width / 3 - 0.5)
        last = min(last, (third + 1) * width / 3 - 0.5 - 1e-6)
    u = _drawn(draw, first, last, size, radius)
    least, greatest = disparities(calibration, range, u, v, radius, objects)
    disparity = draw.uniform(least, greatest)
    rotation = draw.uniform(-range.steepest, range.steepest)
    return PatchPlace(u, v, disparity, rotation, radius)


def specific_place(
    intention: Intention | None,
    calibration: Calibration,
    size: tuple[int, int],
    seed: Seed,
    *,
    radius: float = RADIUS,
    range: PatchRange = PatchRange(),
    objects: Boxes3D | None = None,
) -> PatchPlace:
    """A place in the third of the left image that the driving intention points to.

    Args:
        intention: Driving intention: left, middle or right third.
        calibration: Calibration of the cameras; see `random_place`.
        size: Height and width.
        seed: Seed of the draw.
        radius: Radius of the disc, pixels.
        range: Range of distances.
        objects: Real objects.

    Raises:
        ConfigurationError: There is no intention, or no room.
    """
    if intention is None:
        raise ConfigurationError(
            "a specific patch attack needs to know where the car is going to drive: give "
            "Victim.intention, or place the patch at random"
        )
    return random_place(
        calibration,
        size,
        seed,
        radius=radius,
        range=range,
        objects=objects,
        intention=intention,
    )


def disparities(
    calibration: Calibration,
    range: PatchRange,
    u: float,
    v: float,
    radius: float,
    objects: Boxes3D | None = None,
) -> tuple[float, float]:
    """Least and greatest disparity that a patch can have.

    It is in the range and above the ground; in front of what it covers, even if that takes it
    nearer than the range; and whole in the right image.

    Args:
        calibration: Calibration of the cameras.
        range: Range of distances.
        u: Column of the disc's centre in the left image, pixels; at ``u - radius`` at least the
            range's least disparity.
        v: Row of the disc's centre in the left image, pixels.
        radius: Radius of the disc, pixels.
        objects: Real objects.
    """
    least = range.least_disparity(calibration, v + radius)
    greatest = range.greatest_disparity(calibration)
    if objects is not None:
        behind = nearest_behind(calibration, objects, u, v, radius)
        least = max(least, focal_times_baseline(calibration) / behind)
    whole = u - radius - _ROUNDING
    return min(least, whole), min(max(least, greatest), whole)


def focal_times_baseline(calibration: Calibration) -> float:
    """Disparity times depth, pixels x metres."""
    return calibration.focal_length(LEFT) * calibration.baseline(LEFT, RIGHT)


def _drawn(
    draw: np.random.Generator, first: float, last: float, size: tuple[int, int], radius: float
) -> float:
    if not first <= last:
        raise ConfigurationError(
            f"images of {size[1]} x {size[0]} pixels have no room for a patch of radius "
            f"{radius:g} that both show whole"
        )
    return float(draw.uniform(first, last))


def nearest_behind(
    calibration: Calibration, objects: Boxes3D, u: float, v: float, radius: float
) -> float:
    """Depth where the nearest of the objects begins that a disc touches; infinite without any.

    Args:
        calibration: Calibration of the cameras.
        objects: Real objects.
        u: Column of the disc's centre in the left image, pixels.
        v: Row of the disc's centre in the left image, pixels.
        radius: Radius of the disc, pixels.
    """
    corners = box_corners(objects.location, objects.dimensions, objects.rotation_y)
    pixels, depth = project(calibration.projection(LEFT), corners)
    nearest = depth.min(axis=1)
    # What reaches behind the camera has no rectangle in the image, and is beside the car anyway.
    pixels, nearest = pixels[nearest > 0], nearest[nearest > 0]
    centre = np.array([u, v])
    gap = np.clip(centre, pixels.min(axis=1), pixels.max(axis=1)) - centre
    return float(nearest[np.hypot(*gap.T) < radius].min(initial=np.inf))
