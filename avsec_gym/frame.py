"""What the sensors of a car deliver at one instant: images, a LiDAR scan, and their calibration.

Camera frame, velodyne frame: see `avsec_gym.geometry`.  Cameras are counted as in KITTI: 0 and 1
grey, 2 the left colour camera and the benchmark's reference, 3 the right one; rigs may have more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avsec_gym.connected_scans import ConnectedScans
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats

Image = NDArray[np.uint8]
"""Shape (H, W, 3), red, green, blue."""
Points = NDArray[np.float32]
"""Shape (M, 4): x, y, z in the velodyne frame (metres), reflectance."""

_FARTHEST_SENSOR = 1000.0  # Metres from another one, on one vehicle or its trailer: generous.
_SAME_PIXEL = 0.1
"""Pixels: cameras of a rectified pair see what is far away at one place."""
_LONGEST_FOCUS = 1e5  # Pixels: a telescope's.


@dataclass(frozen=True, eq=False)
class Calibration:
    """Where the sensors are and how the cameras see, in KITTI's terms.

    Args:
        projections: KITTI's matrices P, shape (cameras, 3, 4): from the rectified frame of
            camera 0 to pixels; all zero for a camera that the rig lacks.
        r0_rect: The rotation from camera 0 to its rectified frame, shape (3, 3).
        tr_velo_to_cam: The transform from the velodyne frame to camera 0, shape (3, 4).
        tr_imu_to_velo: The transform from the inertial unit to the velodyne frame, shape (3, 4), if
            known.

    Raises:
        ConfigurationError: A shape does not fit, a value is not finite, a rotation is none, a
            focal length is not positive, the third row of a projection does not begin with 0 0 1,
            or a sensor is a kilometre away.
    """

    projections: Floats
    r0_rect: Floats
    tr_velo_to_cam: Floats
    tr_imu_to_velo: Floats | None = None

    def __post_init__(self) -> None:
        shapes: dict[str, tuple[int, ...]] = {
            "projections": (len(self.projections), 3, 4),
            "r0_rect": (3, 3),
            "tr_velo_to_cam": (3, 4),
            "tr_imu_to_velo": (3, 4),
        }
        for name, shape in shapes.items():
            if name == "tr_imu_to_velo" and self.tr_imu_to_velo is None:
                continue
            array = np.array(getattr(self, name), np.float64)
            if array.shape != shape:
                raise ConfigurationError(f"{name} has shape {array.shape}, expected {shape}")
            if not np.isfinite(array).all():
                raise ConfigurationError(f"{name} holds a value that is not finite")
            rotation = array[:, :3]
            if name != "projections" and not (
                np.abs(rotation @ rotation.T - np.eye(3)).max() < 1e-2
                and np.linalg.det(rotation) > 0
            ):
                raise ConfigurationError(f"the left 3x3 part of {name} is not a rotation")
            if array.shape == (3, 4) and np.abs(array[:, 3]).max() > _FARTHEST_SENSOR:
                raise ConfigurationError(f"{name} moves by more than {_FARTHEST_SENSOR:g} m")
            object.__setattr__(self, name, array)
        for camera in self.cameras:
            _check_projection(f"P{camera}", self.projections[camera])

    @property
    def cameras(self) -> tuple[int, ...]:
        """The calibrated cameras."""
        return tuple(i for i, matrix in enumerate(self.projections) if matrix.any())

    def projection(self, camera: int = 2) -> Floats:
        """P of a camera, shape (3, 4), as `avsec_gym.geometry.project` takes it.

        Raises:
            ConfigurationError: The rig has no such camera.
        """
        if camera not in self.cameras:
            raise ConfigurationError(
                f"camera {camera} is not calibrated; cameras {self.cameras} are"
            )
        return np.asarray(self.projections[camera])

    def focal_length(self, camera: int = 2) -> float:
        """Horizontal focal length, pixels."""
        return float(self.projection(camera)[0, 0])

    def camera_centre(self, camera: int = 2) -> Floats:
        """Where a camera is in the rectified frame of camera 0, shape (3,), metres."""
        matrix = self.projection(camera)
        return np.asarray(-np.linalg.solve(matrix[:, :3], matrix[:, 3]))

    def baseline(self, left: int = 2, right: int = 3) -> float:
        """How far the right camera is to the right of the left one, metres: disparity = f b / z.

        Raises:
            ConfigurationError: A camera is not calibrated, or the two are not rectified to the
                same focal length and principal point: then no disparity has a depth by f b / z.
        """
        first, second = self.projection(left), self.projection(right)
        if not np.allclose(first[:, :3], second[:, :3], rtol=0, atol=_SAME_PIXEL):
            raise ConfigurationError(
                f"P{left} and P{right} are not those of a rectified pair: their focal lengths or "
                f"principal points differ by up to {np.abs(first - second)[:, :3].max():g} pixels"
            )
        return float(first[0, 3] / first[0, 0] - second[0, 3] / second[0, 0])

    @property
    def velodyne_to_camera(self) -> Floats:
        """From the velodyne frame to the (rectified) camera frame, shape (4, 4)."""
        rectification = np.eye(4)
        rectification[:3, :3] = self.r0_rect
        return rectification @ _homogeneous(self.tr_velo_to_cam)

    @property
    def camera_to_velodyne(self) -> Floats:
        """From the (rectified) camera frame to the velodyne frame, shape (4, 4)."""
        return np.asarray(np.linalg.inv(self.velodyne_to_camera))


@dataclass(frozen=True, eq=False)
class StereoPair:
    """Two rectified images of one instant.

    Args:
        left: The left image, shape (H, W, 3).
        right: The right image, of the same shape.
        focal_length: The focal length of both, in pixels.
        baseline: The distance of the cameras, in metres.

    Raises:
        ConfigurationError: The images differ in shape, or focal length or baseline is not positive.
    """

    left: Image
    right: Image
    focal_length: float
    baseline: float

    def __post_init__(self) -> None:
        if self.left.shape != self.right.shape:
            raise ConfigurationError(
                f"a stereo pair has one size, got {self.left.shape} and {self.right.shape}"
            )
        if not (self.focal_length > 0 and self.baseline > 0):
            raise ConfigurationError(
                f"focal length and baseline are positive, got {self.focal_length:g} px and "
                f"{self.baseline:g} m: are left and right exchanged?"
            )


@dataclass(frozen=True, eq=False)
class SensorFrame:
    """One instant of all sensors; images and scan are loaded when first asked for, and kept.

    Treat the arrays as read-only: whoever asks again gets the same ones.  An attack returns a
    new frame by `with_image` and `with_points`.

    Args:
        id: The frame's id, such as ``000107``.
        calibration: The calibration of the whole rig.
        images: The images by camera; `LazyImages` where they are to be loaded on demand.
        scan: The LiDAR's points, or a function that loads them; None without LiDAR.
        previous: Earlier frames, the latest first.
        origin: The folder that it was read from, for messages.
        neighbours: What connected vehicles share at this instant, or a function that loads it; None
            where there are none.
    """

    id: str
    calibration: Calibration
    images: Mapping[int, Image] = field(default_factory=dict)
    scan: Points | Callable[[], Points] | None = field(default=None, repr=False)
    previous: tuple[SensorFrame, ...] = field(default=(), repr=False)
    origin: Path | None = None
    neighbours: ConnectedScans | Callable[[], ConnectedScans] | None = field(
        default=None, repr=False
    )

    def image(self, camera: int = 2) -> Image:
        """A camera's image, shape (H, W, 3).

        Raises:
            DataError: The frame has none of this camera, or its file is broken.
        """
        if camera not in self.images:
            raise DataError(
                f"Frame {self.id} has no image of camera {camera}; it has those of "
                f"{sorted(self.images) or 'none'}.",
                path=self.origin,
                remedy=f"KITTI's layout keeps them in image_{camera}/.",
            )
        return self.images[camera]

    @property
    def has_points(self) -> bool:
        """Whether there is a LiDAR scan."""
        return self.scan is not None

    @cached_property
    def points(self) -> Points:
        """The LiDAR scan, shape (M, 4).

        Raises:
            DataError: The frame has none, or its file is broken.
        """
        if self.scan is None:
            raise DataError(
                f"Frame {self.id} has no LiDAR scan.",
                path=self.origin,
                remedy="KITTI's object layout keeps scans in velodyne/.",
            )
        return self.scan() if callable(self.scan) else self.scan

    @cached_property
    def connected(self) -> ConnectedScans:
        """What connected vehicles share at this instant.

        Raises:
            DataError: There are none, or a file is missing or broken.
        """
        if self.neighbours is None:
            raise DataError(
                f"No other vehicle shares its scan at frame {self.id}.",
                path=self.origin,
                remedy="Name a vehicle of a data set of `avsec world make --suite connected`, such"
                ' as DATA/vehicle_0; or drives of connected vehicles, {"source": "drives",'
                ' "vehicles": 3}.',
            )
        return self.neighbours() if callable(self.neighbours) else self.neighbours

    def stereo(self, left: int = 2, right: int = 3) -> StereoPair:
        """Two cameras as a pair.

        Raises:
            DataError: An image is missing or broken, the two differ in size, or the calibration
                is not that of a rectified pair, or right is not right of left.
            ConfigurationError: A camera is not calibrated.
        """
        one, two = self.image(left), self.image(right)
        if one.shape != two.shape:
            path = self.images.path(right) if isinstance(self.images, LazyImages) else None
            raise DataError(
                f"Frame {self.id}: camera {left} has {_size(one)} pixels, camera {right} "
                f"{_size(two)}.",
                path=path or self.origin,
                remedy="Both images of a rectified pair have one size; fetch them again.",
            )
        # Who asks for cameras that are not calibrated errs; numbers that do not fit are the data's.
        focal_length = self.calibration.focal_length(left)
        self.calibration.projection(right)
        try:
            return StereoPair(one, two, focal_length, self.calibration.baseline(left, right))
        except ConfigurationError as error:
            raise DataError(
                f"Frame {self.id}: {error}.",
                path=self.origin,
                remedy="Correct the frame's calibration, or name the left camera first.",
            ) from error

    def with_image(self, camera: int, image: Image) -> SensorFrame:
        """The same frame with another image in one camera."""
        if isinstance(self.images, LazyImages):
            return replace(self, images=self.images.replaced(camera, image))
        return replace(self, images={**self.images, camera: image})

    def with_points(self, points: Points) -> SensorFrame:
        """The same frame with another scan."""
        return replace(self, scan=points)


class LazyImages(Mapping[int, Image]):
    """Images by camera, each loaded when first asked for.

    Args:
        sources: An image of each camera, or a function that loads it; one that has a `path` is
            named by it in errors.
    """

    def __init__(self, sources: Mapping[int, Image | Callable[[], Image]]) -> None:
        self._sources: dict[int, Image | Callable[[], Image]] = dict(sources)
        self._loaded: dict[int, Image] = {}

    def __getitem__(self, camera: int) -> Image:
        if camera not in self._loaded:
            source = self._sources[camera]
            self._loaded[camera] = source() if callable(source) else source
        return self._loaded[camera]

    def __contains__(self, camera: object) -> bool:
        return camera in self._sources

    def __iter__(self) -> Iterator[int]:
        return iter(self._sources)

    def __len__(self) -> int:
        return len(self._sources)

    def __repr__(self) -> str:
        return f"LazyImages({sorted(self)})"

    def path(self, camera: int) -> Path | None:
        """The file of a camera's image, if it comes from one."""
        path: Path | None = getattr(self._sources[camera], "path", None)
        return path

    def replaced(self, camera: int, image: Image) -> LazyImages:
        """Another image in one camera; what is loaded stays loaded."""
        return LazyImages({**self._sources, **self._loaded, camera: image})


def _check_projection(name: str, projection: Floats) -> None:
    """Check that a matrix is the projection of a rectified pinhole camera."""
    focal_lengths = projection[0, 0], projection[1, 1]
    if not (min(focal_lengths) > 0 and max(focal_lengths) <= _LONGEST_FOCUS):
        raise ConfigurationError(
            f"{name} has focal lengths of {focal_lengths[0]:g} and {focal_lengths[1]:g} pixels, "
            f"which lie between 0 and {_LONGEST_FOCUS:g}"
        )
    if not np.allclose(projection[2, :3], [0, 0, 1], rtol=0, atol=1e-6):
        row = " ".join(f"{value:g}" for value in projection[2, :3])
        raise ConfigurationError(f"{name} has a third row of {row}, expected 0 0 1")
    skew = projection[0, 1], projection[1, 0]
    if np.abs(skew).max() > _SAME_PIXEL:
        raise ConfigurationError(
            f"{name} has a skew of {skew[0]:g} and {skew[1]:g} pixels; a rectified camera has none"
        )
    if np.abs(projection[:2, 2]).max() > _LONGEST_FOCUS:
        raise ConfigurationError(f"{name} has its principal point beyond {_LONGEST_FOCUS:g} pixels")
    centre = -np.linalg.solve(projection[:, :3], projection[:, 3])
    if not np.abs(centre).max() <= _FARTHEST_SENSOR:
        raise ConfigurationError(f"{name} stands more than {_FARTHEST_SENSOR:g} m from camera 0")


def _homogeneous(matrix: Floats) -> Floats:
    return np.vstack([matrix, [0.0, 0.0, 0.0, 1.0]])


def _size(image: Image) -> str:
    return f"{image.shape[1]} x {image.shape[0]}"
