from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.closed_loop.recorded.recorded_traffic import RecordedTraffic
from avsec_gym.closed_loop.recorded.windows import Refusal, known_motion, longest_gap

from .made_traffic import driving, motion, parked, traffic


def refused(recording: RecordedTraffic) -> set[Refusal]:
    return set(known_motion(recording).starts(1.0)[1])


def test_a_street_with_parked_cars_on_both_sides_is_driven_in() -> None:
    starts, others = known_motion(traffic(motion(9.0), parked())).starts(1.0)
    assert starts == [0, 10, 20]
    assert not others


def test_cars_that_all_head_one_way_could_all_be_driving() -> None:
    """Five cars in a row at 6 m/s look as standing ones would to a car 6 m/s slower."""
    flow = [driving(20.0 + 12.0 * i, -3.5, 6.0) for i in range(8)]
    recording = traffic(motion(12.0), flow, farthest=90.0)
    assert refused(recording) == {Refusal.ONE_SIDED}
    assert refused(traffic(motion(9.0), parked(against=False))) == {Refusal.ONE_SIDED}


@pytest.mark.parametrize(
    ("recording", "reason"),
    [
        (traffic(motion(9.0, count=50), parked()), Refusal.SHORT),
        (traffic(motion(9.0), [driving(15.0, 0.0, 9.0)]), Refusal.FEW),
        (traffic(motion(9.0), []), Refusal.GAP),
        (traffic(motion(2.0), parked(), known=True), Refusal.SLOW),
        (traffic(motion(30.0), parked(), known=True), Refusal.FAST),
        (traffic(motion(6.0, 0.6), parked(), known=True), Refusal.TURN),
    ],
    ids=lambda value: value.name if isinstance(value, Refusal) else "",
)
def test_what_cannot_be_driven_in_is_refused_by_its_reason(
    recording: RecordedTraffic, reason: Refusal
) -> None:
    assert refused(recording) == {reason}


def test_the_longest_gap() -> None:
    assert longest_gap(np.array([True, False, False, True])) == 2
    assert longest_gap(np.ones(3, bool)) == 0
    assert longest_gap(np.zeros(3, bool)) == 3
