"""Rates of the object-level baseline against plain loops over frames and states."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from avsec_gym.experiments.chapter3.objects.baseline_rates import baseline_rates, pairs_of
from avsec_gym.experiments.chapter3.objects.mismatch_counts import IOUS
from avsec_gym.experiments.chapter3.recordings import SYSTEM
from avsec_gym.geometry import Floats

PAIRS = list(SYSTEM.pairs())


def counts(frames: int, seed: int) -> Floats:
    random = np.random.default_rng(seed)
    clean = random.poisson(1.0, (frames, len(PAIRS), len(IOUS), 1, 1))
    return clean + random.poisson([[0, 1], [1, 2]], (frames, len(PAIRS), len(IOUS), 2, 2))


def total(one: Floats, iou: float, pairs: list[tuple[int, int]], attacked: tuple[int, ...]) -> int:
    column = IOUS.index(iou)
    return sum(
        int(one[PAIRS.index((i, k)), column, int(i in attacked), int(k in attacked)])
        for i, k in pairs
    )


def test_alarms_are_those_of_plain_loops() -> None:
    fitted, judged = counts(40, 0), counts(30, 1)
    rows = baseline_rates(fitted, judged, [str(number) for number in range(30)])
    assert len({(row.scenario, row.iou, row.rate) for row in rows}) == 2 * 2 * 6
    scenarios = {
        "LiDAR and two cameras": ((0, 2, 3), [(0, 2), (0, 3)]),
        "three cameras": ((1, 2, 3), [(1, 2), (1, 3), (2, 3)]),
    }
    for row in rows:
        triple, pairs = scenarios[row.scenario]
        assert list(pairs_of(triple, SYSTEM)) == pairs
        iou, rate, most = row.iou, row.rate, row.most
        clean = [total(boxes, iou, pairs, ()) for boxes in fitted]
        if rate is None:
            assert most == 0
        else:
            assert sum(count > most for count in clean) <= rate * len(clean)
            # One mismatch less would raise the alarm too often.
            assert sum(count > most - 1 for count in clean) > rate * len(clean)
        shares = {
            "+".join(f"S{sensor}" for sensor in case): np.mean(
                [total(boxes, iou, pairs, case) > most for boxes in judged]
            )
            for size in (1, 2, 3)
            for case in combinations(triple, size)
        }
        assert row.rates.cases == pytest.approx(shares)
        assert row.rates.average == pytest.approx(np.mean(list(shares.values())))
        assert row.rates.interval[0] <= row.rates.average <= row.rates.interval[1]
        alarms = sum(total(boxes, iou, pairs, ()) > most for boxes in judged)
        assert (row.rates.false_alarms.count, row.rates.false_alarms.of) == (alarms, 30)
