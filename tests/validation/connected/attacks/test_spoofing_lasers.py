"""How much of a ghost a laser places."""

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.attacks.spoofing_lasers import LASERS, SpoofingLaser
from avsec_gym.validation.connected.recordings import RecordedInstant
from tests.validation.connected.conftest import POSES, scan_of

_CAR = (14.0, 3.0, 0.1)


def _fan(degrees: np.ndarray) -> np.ndarray:
    angle = np.radians(degrees)
    x, y = 10 * np.cos(angle), 10 * np.sin(angle)
    return np.c_[x, y, np.zeros(len(x)), np.full(len(x), 0.5)].astype(np.float32)


@pytest.mark.parametrize("middle", [0.0, 90.0, 180.0])
def test_the_fullest_sector_is_placed(middle: float) -> None:
    # Thirty points within 6 degrees, ten more 15 degrees away.
    degrees = middle + np.r_[np.linspace(-3, 3, 30), np.linspace(15, 18, 10)]
    placed = SpoofingLaser(100, 8.0).placeable(_fan(degrees))
    np.testing.assert_array_equal(placed, _fan(degrees)[:30])


def test_too_many_are_thinned_evenly() -> None:
    degrees = np.linspace(-2, 2, 401)
    placed = SpoofingLaser(5, 10.0).placeable(_fan(degrees))
    found = np.degrees(np.arctan2(placed[:, 1], placed[:, 0]))
    np.testing.assert_allclose(found, [-2, -1, 0, 1, 2], atol=1e-4)
    assert len(SpoofingLaser(5, 10.0).placeable(_fan(degrees[:0]))) == 0


@pytest.mark.parametrize("laser", LASERS)
def test_a_ghost_keeps_within_the_limits_of_its_paper(laser: str) -> None:
    instant = RecordedInstant("a", tuple(scan_of(pose, _CAR) for pose in POSES))
    limits = LASERS[laser]
    for seed in range(3):
        whole = PastedObject(vehicle=0, distance=(6.0, 12.0)).attack(instant, seed)
        limited = PastedObject(vehicle=0, distance=(6.0, 12.0), laser=laser).attack(instant, seed)
        assert whole is not None
        assert limited is not None
        assert 0 < limited.points <= limits.points
        assert limited.points <= whole.points
        np.testing.assert_array_equal(limited.box.centre, whole.box.centre)
        ghost = limited.instant.scans[0].points[-limited.points :, :2].astype(float)
        ghost /= np.linalg.norm(ghost, axis=1, keepdims=True)
        widest = np.degrees(np.arccos(np.clip(ghost @ ghost.T, -1, 1).min()))
        assert widest <= limits.sector + 1e-3


def test_a_laser_of_no_paper_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="laser"):
        PastedObject(laser="sun")
