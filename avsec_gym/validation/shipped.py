"""Thresholds and likelihoods that the package ships, for users without clean frames of a rig.

They were fitted on the procedural world by `studies.chapter3.shipped_fits.fit`, for some sensors of
KITTI's rig.  They know nothing of the clean frames of a real vehicle: users who have enough of
those fit on them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Literal

import numpy as np

import avsec_gym
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import KITTI_SYSTEM, LIDAR, SensorSystem
from avsec_gym.storage.regular_files import read_text
from avsec_gym.storage.source_code import code_of
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import FittedOn, fitted_on
from avsec_gym.validation.likelihood.maximum_likelihood import read_likelihood_model
from avsec_gym.validation.thresholds import read_threshold_table

FitKind = Literal["thresholds", "likelihood"]

SHIPPED = "shipped"
"""The word that users type in place of a file."""
SHIPPED_SYSTEMS = (
    KITTI_SYSTEM,
    SensorSystem((LIDAR, 3, 2)),
    SensorSystem((1, 3, 2)),
)
"""Shipped systems of KITTI's rig: LiDAR and cameras 1, 3 and 2; those of a frame in the object
layout; cameras."""
FITS = Path(__file__).parent / "fits"
"""Where the files are."""

_SAME_FOCAL_LENGTH = 0.05
_SAME_SIZE = 0.1
"""Recording days of KITTI differ by less, rigs by more."""
_SAME_PLACE = 0.3
"""Metres; of a LiDAR, as seen from the reference camera."""
_SOURCES = (
    "validation/evidence",
    *(f"perception/depth/{name}.py" for name in ("depth", "lidar", "sgbm")),
)
"""What evidence comes from."""


def shipped_file(kind: FitKind, system: SensorSystem, folder: Path = FITS) -> Path:
    """The file that was fitted on the procedural world with these sensors, there or not.

    Example:
        >>> shipped_file("thresholds", SensorSystem(("lidar", 3, 2))).name
        'kitti_lidar_3_2.thresholds.json'
    """
    return folder / f"kitti_{'_'.join(map(str, system.sensors))}.{kind}.json"


def shipped_fit(
    kind: FitKind, system: SensorSystem, depth: PairDepth, frame: SensorFrame, folder: Path = FITS
) -> Path:
    """The shipped file that holds for these sensors of a vehicle.

    Args:
        kind: Thresholds or likelihoods.
        system: The sensors.
        depth: How disparities of two cameras are found.
        frame: A frame of the vehicle; its calibration and the size of its images are compared.
        folder: Where the files are.

    Raises:
        ConfigurationError: Nothing is shipped for such sensors, such depth or such a rig.
        DataError: The file is of another format, or damaged; or the frame's image is.
    """
    path, what = shipped_file(kind, system, folder), f"{kind.removesuffix('s')}s"
    if system not in SHIPPED_SYSTEMS:
        known = "; ".join(
            " ".join(map(str, known_system.sensors)) for known_system in SHIPPED_SYSTEMS
        )
        raise ConfigurationError(
            f"the package ships no {what} of the sensors {' '.join(map(str, system.sensors))}, but "
            f"of {known}"
        )
    on = (read_threshold_table if kind == "thresholds" else read_likelihood_model)(path).on
    try:
        on.check(system, depth, frame.calibration)
    except ConfigurationError as error:
        raise ConfigurationError(f"the package's {what} do not hold here: {error}") from error
    if others := _differences(on.data, rig_of(frame, system)):
        raise ConfigurationError(
            f"the package's {what} do not hold here, they were fitted on another rig: "
            + "; ".join(others)
        )
    return path


def shipped_on(
    system: SensorSystem, depth: PairDepth, frame: SensorFrame, data: Mapping[str, Any]
) -> FittedOn:
    """The sensors and data that a shipped file names.

    Args:
        system: The sensors.
        depth: How disparities are found.
        frame: A frame of the rig.
        data: ``seed`` and ``frames``, and what else names the frames; JSON-able.
    """
    versions = {"avsec_gym": avsec_gym.__version__, "sources": evidence_sources()}
    named = {"shipped": "KITTI's rig", **data, **rig_of(frame, system), **versions}
    return fitted_on(system, depth, frame.calibration, named)


def rig_of(frame: SensorFrame, system: SensorSystem) -> dict[str, Any]:
    """What is compared of a rig, besides its cameras' baselines.

    Returns:
        ``focal_length`` of the reference, pixels; ``size`` of its images; ``lidar``, where the
        LiDAR stands in the reference camera's frame, metres, or None.

    Raises:
        DataError: The reference camera's image is broken.
    """
    calibration, reference = frame.calibration, system.reference
    height, width = frame.image(reference).shape[:2]
    place = None
    if system.has_lidar:
        from_lidar = calibration.velodyne_to_camera[:3, 3]
        place = [round(float(x), 3) for x in from_lidar - calibration.camera_centre(reference)]
    return {
        "focal_length": round(float(calibration.focal_length(reference)), 3),
        "size": [width, height],
        "lidar": place,
    }


def origin_of(on: FittedOn) -> str:
    """Where thresholds or likelihoods come from, in words; empty if their file does not state it.

    Example:
        >>> origin_of(FittedOn(KITTI_SYSTEM, {}, (), {"recording": "drives", "frames": 10}))
        'fitted on 10 clean frames of drives'
    """
    data = on.data
    if rig := data.get("shipped"):
        return (
            f"fitted on procedural drives of {rig}, seed {data['seed']}, {data['frames']} frames; "
            "not on this vehicle"
        )
    if "recording" in data:
        return f"fitted on {data['frames']} clean frames of {data['recording']}"
    return ""


def stale(on: FittedOn) -> bool:
    """Whether a shipped fit was made by other sources of the evidence than today's."""
    return bool(on.data.get("shipped")) and on.data.get("sources") != evidence_sources()


@cache
def evidence_sources() -> str:
    """Sixteen digits that change with the code that evidence comes from, not with its comments."""
    root, digest = Path(avsec_gym.__file__).parent, hashlib.sha256()
    for name in _SOURCES:
        found = root / name
        for path in [found] if found.is_file() else sorted(found.rglob("*.py")):
            digest.update(code_of(read_text(path)).encode())
    return digest.hexdigest()[:16]


def _differences(fitted: Mapping[str, Any], there: Mapping[str, Any]) -> list[str]:
    """Differences between a rig and the one of the fit."""
    result = []
    ours, theirs = (float(rig["focal_length"]) for rig in (fitted, there))
    if not np.isclose(theirs, ours, rtol=_SAME_FOCAL_LENGTH, atol=0):
        result.append(f"a focal length of {theirs:.0f} px, not {ours:.0f}")
    if not np.allclose(there["size"], fitted["size"], rtol=_SAME_SIZE, atol=0):
        result.append(f"images of {_by(there['size'])} px, not {_by(fitted['size'])}")
    if fitted["lidar"] is not None and not np.allclose(
        there["lidar"], fitted["lidar"], rtol=0, atol=_SAME_PLACE
    ):
        result.append(f"a LiDAR at {there['lidar']} m from the reference, not {fitted['lidar']}")
    return result


def _by(size: Sequence[int]) -> str:
    return " x ".join(map(str, size))
