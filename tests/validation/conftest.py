"""Systems and made-up evidence for the tests of chapter 3."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
import pytest

from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.rig import camera_rig
from avsec_gym.sensor_system import KITTI_SYSTEM, LIDAR, SensorSystem
from avsec_gym.validation.evidence.evidence import evidence_scopes
from avsec_gym.validation.fitted_on import FittedOn


@dataclass(frozen=True, eq=False)
class MadeUp:
    """Evidence of frames whose states are known."""

    evidence: Floats
    states: np.ndarray
    frames: np.ndarray


def system_of(cameras: int) -> SensorSystem:
    """A LiDAR and so many cameras."""
    return SensorSystem((LIDAR, *range(cameras)))


def on(system: SensorSystem) -> FittedOn:
    """Fitted on nothing in particular."""
    return FittedOn(system, {"name": "sgbm"}, (389.0,) * (len(system.cameras) - 1), {"seed": 0})


def make_up(system: SensorSystem, states: np.ndarray, seed: int, damage: float = 0.15) -> MadeUp:
    """What sensors might say; not of the form that the likelihoods assume.

    Shares of beta-distributed noise: of the scene, shared by all; of each disparity map, shared by
    its triples; of each element alone.  An attack spoils a beta-distributed part of the view.

    Args:
        system: Of sensors.
        states: The same frames are shown in each of these states, shape (frames, K, n + 1).
        seed: Of the noise.
        damage: Mean part of the view that an attack spoils.
    """
    rng = np.random.default_rng(seed)
    scopes = evidence_scopes(system)
    fixed = np.random.default_rng(7)
    base = fixed.uniform(0.5, 1.0, len(scopes))
    seen = [fixed.uniform(0.4, 1.0, len(scope)) for scope in scopes]
    evidence = []
    for of_frame in states:
        scene = rng.beta(2, 12)
        noise = rng.beta(2, 60, (len(system), len(system)))
        alone = rng.beta(2, 200, len(scopes))
        for state in of_frame:
            part = rng.beta(4, 4 / damage - 4, len(system)) * state
            row = []
            for e, scope in enumerate(scopes):
                sound = (1 - base[e] * scene) * (1 - alone[e])
                for other in scope[:-1]:
                    sound *= 1 - noise[other, scope[-1]]
                sound *= np.prod(1 - seen[e] * part[list(scope)])
                row.append(rng.binomial(5000, 1 - sound) / 5000)
            evidence.append(row)
    frames = np.repeat(np.arange(len(states)), states.shape[1])
    return MadeUp(np.array(evidence), states.reshape(-1, len(system)), frames)


@pytest.fixture(scope="session")
def made_up() -> Callable[..., MadeUp]:
    return make_up


@pytest.fixture(scope="session")
def kitti_on() -> FittedOn:
    return FittedOn(KITTI_SYSTEM, {"name": "sgbm", "nearest": 3.5}, (48.0, 384.0), {"seed": 0})


@pytest.fixture(scope="session")
def wall_of() -> Callable[[int], SensorFrame]:
    return random_dots


@pytest.fixture(scope="session")
def soft_wall() -> SensorFrame:
    """Grey, since light that is added to white shows nothing, and without sharp edges."""
    frame = random_dots(0)
    for camera in (0, 1, 2):
        image = 0.5 * cv2.GaussianBlur(frame.image(camera), (0, 0), 2.0)
        frame = frame.with_image(camera, image.astype(np.uint8))
    return frame


def random_dots(seed: int) -> SensorFrame:
    """A wall of random dots 8 m ahead, which cameras 0 to 2 and a scan see alike.

    Disparities are 5, 10 and 15 pixels.
    """
    rig = camera_rig([0.0, 0.4, 0.6], focal_length=200.0, centre=(120.0, 60.0), size=(240, 120))
    depth = 8.0
    dots = np.random.default_rng(seed).integers(0, 256, (120, 300, 1), np.uint8).repeat(3, axis=2)
    shifts = [round(200.0 * right / depth) for right in (0.0, 0.4, 0.6)]
    images = {camera: dots[:, shift : shift + 240] for camera, shift in enumerate(shifts)}
    x, y = np.meshgrid(np.linspace(-5, 5, 150), np.linspace(-2, 2, 40))
    places = np.stack([x.ravel(), y.ravel(), np.full(x.size, depth), np.ones(x.size)], axis=1)
    points = (places @ rig.calibration.camera_to_velodyne.T).astype(np.float32)
    return SensorFrame(f"{seed:06d}", rig.calibration, images, points)
