"""A detector behind an attack: which attack a name means, and what the detector is given."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from avsec_gym.attacks.attacked_detector import AttackedDetector, attack_kind
from avsec_gym.attacks.facula import Facula
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.registry import Kind, names
from avsec_gym.rig import kitti_rig


class Camera:
    """A detector that keeps the images it was given."""

    name = "camera"

    def __init__(self) -> None:
        self.seen: list[np.ndarray] = []

    def detect(self, frame: SensorFrame) -> Boxes3D:
        self.seen.append(frame.image(2))
        return Boxes3D.empty()


@pytest.mark.parametrize(
    ("attack", "kind"),
    [
        ("facula", Kind.OPTICAL_ATTACK),
        ({"name": "facula", "camera": 3}, Kind.OPTICAL_ATTACK),
        ("thesis_pgd", Kind.ATTACK),
        ({"name": "thesis_pgd", "steps": 2}, Kind.ATTACK),
    ],
)
def test_the_name_decides_what_kind_of_attack_it_is(attack: Any, kind: Kind) -> None:
    assert attack_kind(attack) is kind


@pytest.mark.parametrize("name", [*names(Kind.ATTACK), *names(Kind.OPTICAL_ATTACK)])
def test_a_slip_in_an_attack_of_either_kind_is_asked_about(name: str) -> None:
    for slip in (f"{name}x", {"name": f"{name}x"}):
        with pytest.raises(ConfigurationError, match=f'Did you mean "{name}"') as raised:
            AttackedDetector("oracle", slip)
        assert "facula" in str(raised.value).partition("Known: ")[2]


def test_the_detector_sees_the_attacked_image() -> None:
    black = np.zeros((375, 1242, 3), np.uint8)
    frame = SensorFrame("000042", kitti_rig().calibration, {2: black, 3: black})
    detector = Camera()
    AttackedDetector(detector, "facula", seed=7).detect(frame)
    # The draw depends on the seed and on the number of the frame.
    expected = Facula().attack(frame, (7, 42)).frame.image(2)
    assert expected.any()
    np.testing.assert_array_equal(detector.seen[0], expected)


def test_what_does_not_detect_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"detector: .* that has detect"):
        AttackedDetector(object(), "facula")
