"""Scans of a known world are registered to where they were taken; others are refused."""

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.raw_drive.registration import register
from tests.validation.connected.conftest import Box, pose_at, scan_of

_PARKED: tuple[Box, ...] = (
    (6, 4, 0.1),
    (14, 4.5, 0.0),
    (21, -5, 1.4),
    (9, -6, 0.2),
    (-7, 5, -0.1),
    (-12, -5, 0.6),
    (30, 3, 0.1),
    (33, -8, -0.5),
)
_SECOND = pose_at(4.3, 0.4, np.radians(3.0))


@pytest.fixture(scope="module")
def scans() -> dict[str, np.ndarray]:
    first = pose_at(0, 0, 0)
    other_street = [(1.6 * x + 5, 1.4 * y + 2, heading + 0.8) for x, y, heading in _PARKED]
    return {
        "first": scan_of(first, *_PARKED, (10, 0, 0)).points,
        # The car ahead goes on as fast as the one with the sensor.
        "second": scan_of(_SECOND, *_PARKED, (14.3, 0, 0)).points,
        "plain": scan_of(first).points,
        "elsewhere": scan_of(first, *other_street).points,
    }


def test_a_scan_is_registered_past_a_car_that_moves_along(scans: dict[str, np.ndarray]) -> None:
    found = register(scans["second"], scans["first"])
    expected = np.linalg.inv(pose_at(0, 0, 0)) @ _SECOND
    assert found.transform[:3, 3] == pytest.approx(expected[:3, 3], abs=0.03)
    assert found.transform[:3, :3] == pytest.approx(expected[:3, :3], abs=0.002)
    assert found.residual < 0.02
    assert found.overlap > 0.5


def test_a_plain_and_another_place_are_refused(scans: dict[str, np.ndarray]) -> None:
    for name in ("plain", "elsewhere"):
        with pytest.raises(DataError, match="cannot be registered"):
            register(scans[name], scans["first"])
    with pytest.raises(DataError, match="cannot be registered"):
        register(scans["plain"], scans["plain"])
    with pytest.raises(DataError, match="0 points"):
        register(scans["first"], np.zeros((9, 4), np.float32))


def test_lines_of_points_are_no_surfaces() -> None:
    """Rings far apart on a plain ground: what lies along a line alone has no normal."""
    along, across = np.meshgrid(np.arange(-40, 40, 0.5), [-30.0, 0.0, 30.0])
    rough = np.random.default_rng(0).normal(0, 1e-3, along.size)
    lines = np.c_[along.ravel(), across.ravel() + rough, np.full((along.size, 2), -1.7)]
    with pytest.raises(DataError, match="without surfaces"):
        register(lines.astype(np.float32), lines.astype(np.float32))
