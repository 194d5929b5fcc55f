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

_NAN = float("nan")


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


def test_near_and_far_pixels_of_a_row_hide_each_other_as_a_plain_search_finds() -> None:
    random = np.random.default_rng(0)
    # Most are in the other image, and half of them hidden there.
    for least, most in ((0.0, 9.0), (5.0, 9.5), (60.0, 68.0), (100.0, 112.0)):
        rows = random.uniform(least, most, (12, 140)).astype(np.float32)
        rows[random.random(rows.shape) < 0.4] = np.nan
        found = seen_by_both(rows)
        assert found.tolist() == [by_loop(row.tolist()) for row in rows]
        assert 0.1 < found.mean() < 0.7


@pytest.mark.parametrize(
    ("row", "seen"),
    [
        ([-0.3, -0.2, 0.0], [False, False, True]),
        ([0.0, 1.0, 2.0], [True, True, True]),
        ([0.25, 1.25, 2.25], [False, False, False]),
        # A pixel that is nearer by 3 pixels hides nothing; by more it hides its neighbours, too.
        ([_NAN, 1.0, _NAN, _NAN, 4.0], [False, True, False, False, True]),
        ([_NAN, 0.75, _NAN, _NAN, 4.0], [False, False, False, False, True]),
        ([0.25, 0.0, _NAN, _NAN, 3.25], [False, False, False, False, True]),
        ([0.0, _NAN, 0.0, _NAN, 0.0, 3.9], [False, False, False, False, True, True]),
    ],
)
def test_hidden_pixels_of_a_short_row(row: list[float], seen: list[bool]) -> None:
    assert seen_by_both(np.array([row])).tolist() == [seen]


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
