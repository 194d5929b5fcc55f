"""Hidden pixels, by rendering every pixel into the other image."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.frame import SensorFrame
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.rig import kitti_rig
from avsec_gym.validation.evidence.pair_depth import PairDepth, WholeWidthMatching
from avsec_gym.validation.evidence.seen_by_both import SeenByBoth, seen_by_both


def by_loop(row: list[float]) -> list[bool]:
    places = [None if np.isnan(d) or d > u else round(u - d) for u, d in enumerate(row)]
    seen = []
    for place, here in zip(places, row, strict=True):
        over = [
            d
            for other, d in zip(places, row, strict=True)
            if place is not None and other is not None and abs(other - place) <= 1
        ]
        seen.append(bool(over) and max(over) - here <= max(3.0, 0.05 * here))
    return seen


@given(
    st.lists(
        st.one_of(st.just(float("nan")), st.integers(0, 120).map(float)), min_size=1, max_size=60
    )
)
def test_hidden_pixels_are_those_of_a_plain_search(row: list[float]) -> None:
    found = seen_by_both(np.array([row, row[::-1]], np.float32))
    assert found.tolist() == [by_loop(row), by_loop(row[::-1])]


def test_a_strip_behind_a_near_object_is_hidden() -> None:
    """An object 20 pixels nearer hides 20 pixels left of it from the camera to the right."""
    disparity = np.full((4, 200), 10.0, np.float32)
    disparity[:, 100:140] = 30.0
    seen = seen_by_both(disparity)
    assert not seen[:, :10].any()
    assert seen[:, 10:78].all()
    assert not seen[:, 81:99].any()
    assert seen[:, 100:].all()


class Everywhere:
    """Answers everywhere."""

    name = "everywhere"

    def disparity(self, frame: SensorFrame) -> DisparityMap:
        return DisparityMap(np.full((2, 50), 20.0, np.float32), 100.0)


def test_a_network_answers_only_where_both_see() -> None:
    rig = kitti_rig()
    image = np.zeros((2, 50, 3), np.uint8)
    found = SeenByBoth(Everywhere()).disparity(SensorFrame("0", rig.calibration, {2: image}))
    assert found.focal_times_baseline == 100.0
    assert found.valid[:, 20:].all()
    assert not found.valid[:, :20].any()


@pytest.mark.parametrize(("what", "kind"), [("sgbm", WholeWidthMatching), ("psmnet", SeenByBoth)])
def test_pairs_of_cameras_are_matched_by(what: str, kind: type) -> None:
    assert isinstance(PairDepth(what).estimator(kitti_rig().calibration, 2, 3), kind)
