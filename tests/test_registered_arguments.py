"""Whatever is given for an argument of a registered part: it is made, or refused in our own words.

Parts and their arguments are read from the registry, so that a new part, and a new argument of an
old one, is covered by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.attacks.object_scan import ObjectScan
from avsec_gym.attacks.optical_attack import OpticalAttack
from avsec_gym.built_in_parts import BUILT_IN, Kind
from avsec_gym.errors import AvsecError, ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.depth import depth
from avsec_gym.registry import _factory
from avsec_gym.rig import kitti_rig
from avsec_gym.sensor_system import KITTI_SYSTEM
from avsec_gym.validation.shipped import shipped_file
from tests.strange_values import STRANGE

VALUES = (*STRANGE, 1e308, -1e308, 2**63, -(2**63), np.float64("nan"), np.array([[], []]))
SCAN = ObjectScan(
    np.array([[1.9, 0.2, 0.5, 0.3], [1.9, -0.3, 0.9, 0.3]], np.float32), (4.0, 1.7, 1.5), (9.0, 0.5)
)
USUAL: dict[str, dict[str, Any]] = {
    "detector attacked": {"detector": "oracle", "attack": "facula"},
    "detector defended": {"detector": "oracle", "defence": "jpeg"},
    "detector replayed": {"detections": Path(__file__).parent},
    "detector single_image": {"detector": "yolo"},
    "attack patch": {"patch": "grey"},
    "classifier vgg16": {"weights": None},
    "attack transferred": {"attack": "fgsm", "of": "oracle"},
    "attack strongest": {"attacks": ["fgsm", "random_noise"]},
    "validator thresholds": {"thresholds": shipped_file("thresholds", KITTI_SYSTEM)},
    "validator likelihood": {"model": shipped_file("likelihood", KITTI_SYSTEM)},
    "optical_attack pasted_scan": {"scan": SCAN},
    "optical_attack thesis": {"sensors": (2, "lidar")},
}
"""What parts cannot be made without."""
FILES = ("weights", "detections", "thresholds", "model", "scan", "patch", "constants")
"""Arguments whose texts are taken for names of files, and may be missing."""


def registered() -> list[Any]:
    parts = [pytest.param(*_factory(*key)[:2], f"{key[0]} {key[1]}", id="-".join(key))
             for key in BUILT_IN]  # fmt: skip
    for name, (path, defaults) in depth._BUILT_IN.items():
        module, attribute = path.split(":")
        made = getattr(__import__(module, fromlist=[attribute]), attribute)
        parts.append(pytest.param(made, defaults, f"depth {name}", id=f"depth-{name}"))
    return parts


def test_every_kind_has_parts_here() -> None:
    assert {kind for kind, _ in BUILT_IN} == set(Kind)


@pytest.mark.parametrize(("factory", "defaults", "part"), registered())
def test_anything_makes_a_part_or_is_refused(
    factory: Callable[..., Any], defaults: dict[str, Any], part: str
) -> None:
    usual = defaults | USUAL.get(part, {})
    names = list(signature(factory).parameters)
    if part == "attack art":
        pytest.importorskip("avsec_gym.attacks.art_estimator")
    factory(**usual)
    for name in names:
        for value in VALUES:
            try:
                made = factory(**{**usual, name: value})
                use(made)
            except AvsecError as error:
                refused(error, name, value)
            except BaseException as error:
                error.add_note(f"{name} = {value!r}"[:200])
                raise


def refused(error: AvsecError, name: str, value: Any) -> None:
    """It is refused as an argument, by its name; files and parts are refused by theirs."""
    if isinstance(error, DataError):
        assert name in FILES, (name, value)
        return
    assert isinstance(error, ConfigurationError)
    text = str(error)
    assert name in text or (isinstance(value, str) and repr(value)[:20] in text), (name, value)
    assert len(text) < 1500, (name, value)


FRAME = SensorFrame(
    "0",
    kitti_rig().calibration,
    {camera: np.full((60, 199, 3), 90, np.uint8) for camera in (0, 1, 2, 3)},
    np.array([[9.0, 0.0, -1.0, 0.3], [-5.0, 2.0, -1.0, 0.3]], np.float32),
)


def use(made: Any) -> None:
    """What was made of a strange value of an optical attack attacks: nothing waits inside of it."""
    if not isinstance(made, OpticalAttack) or not hasattr(made, "sensors"):
        return
    try:
        tampered = made.attack(FRAME, 0)
    except (ConfigurationError, DataError) as error:
        # What only the frame shows: no such camera, a view too narrow for a plane.
        assert any(word in str(error) for word in ("camera", "image", "LiDAR"))  # noqa: PT017
        return
    assert all(np.isfinite(each) for each in tampered.settings.values())
    if tampered.points is not None:
        assert np.isfinite(tampered.frame.points).all()
