"""Regions all around a vehicle: of boxes whose place is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from avsec_gym.box_overlap import rectangle_iou
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import wrap_angle
from avsec_gym.perception.detectors.pixor.upright_boxes import upright_boxes
from avsec_gym.registry import Kind, make
from avsec_gym.validation.connected.merging import seen_from_above
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.proposals.ground_map import ground_map
from avsec_gym.validation.connected.proposals.rectangle_fit import fitted_rectangle
from avsec_gym.validation.connected.proposals.sectors import SectorProposer
from tests.validation.connected.conftest import CARS, POSES, scan_of

_GROUND = -1.73


def _slope(x: np.ndarray) -> np.ndarray:
    return _GROUND + 0.03 * x


def _street() -> np.ndarray:
    side = np.arange(-40, 40, 0.4)
    x, y = (axis.ravel() for axis in np.meshgrid(side, side))
    return np.c_[x, y, _slope(x)]


def _near_sides(x: float, y: float, heading: float) -> np.ndarray:
    """The end and the side of a car of 4.2 x 1.8 x 1.5 m that the sensor at the origin sees."""
    cos, sin = np.cos(heading), np.sin(heading)
    end = 2.1 * (1 if cos * -x + sin * -y > 0 else -1)
    side = 0.9 * (1 if cos * -y - sin * -x > 0 else -1)
    along, across = np.arange(-2.1, 2.11, 0.1), np.arange(-0.9, 0.91, 0.1)
    outline = np.r_[np.c_[along, 0 * along + side], np.c_[0 * across + end, across]]
    place = outline @ np.array([[cos, sin], [-sin, cos]]) + [x, y]
    up = np.arange(0.05, 1.5, 0.2)
    every = np.repeat(place, len(up), axis=0)
    return np.c_[every, _slope(every[:, 0]) + np.tile(up, len(place))]


def _scan(*parts: np.ndarray) -> np.ndarray:
    places = np.concatenate(parts)
    return np.c_[places, np.zeros(len(places))].astype(np.float32)


def test_it_looks_as_far_along_y_as_along_x() -> None:
    """A car inside of the reach has its region; beyond, on either axis, it has none."""
    propose = ClusterProposer(reach=30.0)
    for x, y, seen in (
        (20.0, 6.0, True),
        (6.0, 20.0, True),
        (36.0, 6.0, False),
        (6.0, -36.0, False),
    ):
        assert len(propose(_scan(_street(), _near_sides(x, y, 0.3)))) == seen


@settings(deadline=None, max_examples=25)
@given(st.floats(-np.pi, np.pi), st.floats(8, 30), st.floats(-np.pi, np.pi))
def test_a_car_anywhere_around_has_its_region(
    bearing: float, distance: float, heading: float
) -> None:
    x, y = distance * np.cos(bearing), distance * np.sin(bearing)
    regions = ClusterProposer()(_scan(_street(), _near_sides(x, y, heading)))
    assert len(regions) == 1
    iou = rectangle_iou([[x, y, 4.2, 1.8, heading]], seen_from_above(regions))
    assert iou[0, 0] > 0.6
    assert regions.centre[0, 2] == pytest.approx(_slope(np.array(x)), abs=0.25)


def test_walls_and_poles_have_none() -> None:
    x, z = (axis.ravel() for axis in np.meshgrid(np.arange(-20, 20, 0.1), np.arange(-1.7, 0, 0.2)))
    wall = np.c_[x, np.full(len(x), 8.0), z]
    pole = np.c_[np.full(9, 6.0), np.full(9, -6.0), np.linspace(-1.5, 1.0, 9)]
    assert len(ClusterProposer()(_scan(_street(), wall, pole))) == 0
    assert len(ClusterProposer()(_scan(_street())[:0])) == 0


def test_the_ground_under_a_car_is_the_street() -> None:
    places = np.r_[_street(), _near_sides(12.0, 3.0, 0.3)]
    ground = ground_map(places, 60.0)
    where = np.array([[12.0, 3.0], [-10.0, 5.0], [0.0, 0.0]])
    assert ground.height(where) == pytest.approx(_slope(where[:, 0]), abs=0.15)


@given(st.floats(-3.0, 3.0))
def test_an_l_shape_has_its_rectangle(heading: float) -> None:
    x, y, length, width, found = fitted_rectangle(_near_sides(10.0, 4.0, heading)[:, :2])
    assert (x, y) == pytest.approx((10.0, 4.0), abs=0.15)
    assert (length, width) == pytest.approx((4.2, 1.8), abs=0.3)
    assert abs(np.sin(found - heading)) < 0.06


class _OnlyAhead:
    """A detector that proposes a box at each point within 30 degrees of ahead."""

    def propose(self, frame: SensorFrame) -> Boxes3D:
        points = frame.points[np.abs(np.arctan2(frame.points[:, 1], frame.points[:, 0])) < 0.55]
        ahead = np.zeros(len(points))
        rectangles = np.c_[points[:, :2], ahead + 4.0, ahead + 1.8, ahead + 0.2]
        return upright_boxes(rectangles, points[:, 2], ahead + 0.9, "Car", 1.5, frame.calibration)


def test_sectors_turn_every_bearing_ahead_and_back() -> None:
    bearing = np.radians(np.arange(0, 360, 36.0))
    points = np.c_[20 * np.cos(bearing), 20 * np.sin(bearing), 0 * bearing + _GROUND, 0 * bearing]
    regions = SectorProposer(_OnlyAhead())(points.astype(np.float32))  # type: ignore[arg-type]
    assert len(regions) == 10  # In two sectors or one, each is proposed once.
    for x, y, z, _ in points:
        away = np.linalg.norm(regions.centre - [x, y, z], axis=1)
        assert away.min() < 0.01
        # The box was turned by 0.2 where its sector was ahead.
        turned = np.degrees(wrap_angle(regions.heading[away.argmin()] - 0.2)) % 60
        assert min(turned, 60 - turned) < 1.0
    with pytest.raises(ConfigurationError):
        SectorProposer(_OnlyAhead(), sectors=4)  # type: ignore[arg-type]


@pytest.mark.parametrize("turned", [0.0, 2.5])
def test_pixor_looks_all_around(turned: float) -> None:
    points = scan_of(POSES[0], *CARS).points.copy()
    cos, sin = np.cos(turned), np.sin(turned)
    points[:, :2] = points[:, :2] @ np.array([[cos, sin], [-sin, cos]])
    regions = SectorProposer(make(Kind.DETECTOR, "pixor"))(points.astype(np.float32))
    to_vehicle = np.linalg.inv(POSES[0])
    cars = np.array(CARS)[:, :2] @ to_vehicle[:2, :2].T + to_vehicle[:2, 3]
    cars = cars @ np.array([[cos, sin], [-sin, cos]])
    away = np.linalg.norm(regions.centre[:, None, :2] - cars, axis=2)
    # The nearest ones, and nothing that is none, wherever the vehicle looks.
    assert len(regions) >= 3
    assert (away.min(axis=1) < 1.5).all()
    assert len(set(away.argmin(axis=1))) == len(regions)
