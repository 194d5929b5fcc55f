"""A poster stays on its vehicle or at its place, and grows as one approaches."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from avsec_gym.attacks.patch_files import Patch, shipped_patch
from avsec_gym.closed_loop.attack.lasting_patch import LastingPatch
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import kitti_rig, resized_rig
from tests.closed_loop.attack.surroundings import around

RIG = resized_rig(kitti_rig(), 414)
FOCAL = RIG.calibration.focal_length(2)
WHITE = Patch(torch.full((3, 16, 16), 255.0))
ON_VEHICLE = np.array([1.0, 1.0, 0.375, 0.0, 0.0])
"""On what is nearest to 30 m straight ahead, actor 7, whose rear is 28 m ahead; 1.25 m wide."""
AT_PLACE = np.array([1.0, -1.0, 0.0, -0.5, -1.0])
"""24 m ahead, 4 m to the right; 0.5 m wide."""
START = (0.0, 0.0, 0.0)


def black() -> SensorFrame:
    image = np.zeros((125, 414, 3), np.uint8)
    return SensorFrame("000000", RIG.calibration, {2: image, 3: image})


def seen(attack: LastingPatch, pose: tuple[float, float, float], camera: int = 2) -> np.ndarray:
    return attack.tampered(black(), around(pose)).image(camera)[..., 0].astype(float)


def centre_and_width(shown: np.ndarray) -> tuple[float, float]:
    """Column of the middle, and the width of a disc of such an area, pixels."""
    columns = np.arange(shown.shape[1])
    middle = float((shown.sum(axis=0) * columns).sum() / shown.sum())
    return middle, 2 * float(np.sqrt(shown.sum() / 255.0 / np.pi))


@pytest.mark.parametrize(
    ("action", "place", "diameter"),
    [(ON_VEHICLE, (28.0, 0.0), 1.25), (AT_PLACE, (24.0, -4.0), 0.5)],
)
def test_it_grows_as_the_car_approaches(
    action: np.ndarray, place: tuple[float, float], diameter: float
) -> None:
    """As wide as f D / Z, where the place is seen, and f b / Z further left in the right image."""
    attack = LastingPatch(WHITE)
    attack.act(action, around(START))
    baseline = RIG.calibration.baseline(2, 3)
    widths = []
    for ahead in (0.0, 8.0, 14.0):
        depth = place[0] - ahead
        middle, width = centre_and_width(seen(attack, (ahead, 0.0, 0.0)))
        # Boxes lie in the frame of camera 0, which is 6 cm from camera 2.
        offset = RIG.calibration.projection(2)[0, 3]
        column = RIG.calibration.projection(2)[0, 2] + (offset - FOCAL * place[1]) / depth
        assert middle == pytest.approx(column, abs=1.0)
        # The disc's edge fades over a pixel.
        assert width == pytest.approx(FOCAL * diameter / depth, abs=1.1)
        other, _ = centre_and_width(seen(attack, (ahead, 0.0, 0.0), 3))
        assert middle - other == pytest.approx(FOCAL * baseline / depth, abs=0.5)
        widths.append(width)
        attack.act(-action + [2 * action[0], 0, 0, 0, 0], around((ahead, 0.0, 0.0)))  # It stays.
    assert widths[0] < widths[1] < widths[2]


def test_a_vehicle_takes_it_along() -> None:
    """The rear of a vehicle 20 m further on is so far away; what is in front covers it."""
    attack = LastingPatch(WHITE)
    attack.act(ON_VEHICLE, around(START))
    gone_on = np.array([[50.0, 0.0, 0.0], [20.0, 3.5, 0.0]])
    place = attack.place(RIG.calibration, around(START, gone_on))
    assert place is not None
    assert place.radius == pytest.approx(FOCAL * 0.625 / 48.0, rel=0.01)
    between = np.array([[50.0, 0.0, 0.0], [20.0, 0.0, 0.0]])
    assert attack.place(RIG.calibration, around(START, between)) is None
    assert attack.place(RIG.calibration, around((60.0, 0.0, 0.0), gone_on)) is None
    # The vehicle has left the scene: the poster is up, and nowhere.
    empty = around(START, np.zeros((0, 3)))
    assert attack.place(RIG.calibration, empty) is None
    assert attack.state(empty).tolist() == [1.0, 1.0, 0.0, 0.0, 0.0]


def test_an_oncoming_vehicle_carries_it_in_front_and_no_poster_is_larger_than_its_carrier() -> None:
    attack = LastingPatch(WHITE)
    attack.act(np.array([1.0, 1.0, 0.375, 0.0, 1.0]), around(START))
    oncoming = around(START, np.array([[30.0, 0.0, np.pi], [20.0, 3.5, 0.0]]))
    place = attack.place(RIG.calibration, oncoming)
    assert place is not None
    assert place.radius == pytest.approx(FOCAL * 0.75 / 28.0, rel=0.01)


def test_its_energy_is_its_area_and_down_is_down() -> None:
    attack = LastingPatch(WHITE)
    assert attack.act(AT_PLACE, around(START)) == pytest.approx((0.5 / 2.0) ** 2)
    assert attack.facts == {"diameter": 0.5, "carried": 0.0}
    assert attack.act(-np.ones(5), around(START)) == 0.0
    assert seen(attack, START).max() == 0.0
    attack.act(AT_PLACE, around(START))
    assert attack.tampered(black(), around(START)).image(2).dtype == np.uint8
    attack.begin()
    assert attack.act(ON_VEHICLE, around(START, np.zeros((0, 3)))) == 0.0


def test_by_itself_it_is_the_packages_patch_against_both_detectors() -> None:
    own = LastingPatch().patch
    assert own.card is not None
    assert len(own.card.detectors) == 2
    assert torch.equal(own.pixels, LastingPatch(shipped_patch("joint")).patch.pixels)
    with pytest.raises(ConfigurationError, match="patch takes"):
        LastingPatch(5)  # type: ignore[arg-type]
    with pytest.raises(DataError, match="gone"):
        LastingPatch("gone.safetensors")
