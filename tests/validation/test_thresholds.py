"""Thresholds as order statistics of attack-free data, and their files."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import beta

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.perception.depth.psmnet_depth import PsmNetDepth
from avsec_gym.perception.weights.weights_hash import weights_hash
from avsec_gym.rig import camera_rig, kitti_rig
from avsec_gym.sensor_system import KITTI_SYSTEM, LIDAR, SensorSystem
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS, detect_attack
from avsec_gym.validation.evidence.disparity_error import MEASURES, DisparityError
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import FittedOn, fitted_on, read_fitted, write_fitted
from avsec_gym.validation.threshold_validator import ThresholdValidator
from avsec_gym.validation.thresholds import (
    Criterion,
    Threshold,
    ThresholdTable,
    read_threshold_table,
)
from avsec_gym.validation.validator import SHARES

THREE_CAMERAS = SensorSystem((1, 3, 2))
"""The thesis' scenario 2."""
CRITERIA: tuple[Criterion, ...] = (*MEASURES, "any")


def table_of(on: FittedOn, frames: list[dict[Any, DisparityError]]) -> ThresholdTable:
    """The table of attack-free frames, of the errors of all triples of each."""
    shares = [[frame[triple].shares for triple in on.system.triples] for frame in frames]
    return ThresholdTable(on, np.array(shares))


def samples(on: FittedOn, count: int = 200) -> list[dict[Any, DisparityError]]:
    rng = np.random.default_rng(1)
    frames = []
    for valid, bad, others in zip(
        rng.integers(5000, 9001, (count, 4)),
        rng.beta(2, 20, (count, 4)),
        rng.beta(2, 20, (count, 4, 2)),
        strict=True,
    ):
        errors = [
            DisparityError(int(b * v), int(v), 9000, *other)
            for v, b, other in zip(valid, bad, others, strict=True)
        ]
        frames.append(dict(zip(on.system.triples, errors, strict=True)))
    return frames


@pytest.mark.parametrize("criterion", CRITERIA)
@pytest.mark.parametrize("rate", [0.0, 0.01, 0.05, 0.29, 0.5, 1.0])
def test_the_share_r_of_the_samples_lies_beyond(
    kitti_on: FittedOn, rate: float, criterion: Criterion
) -> None:
    frames = samples(kitti_on)
    thresholds = table_of(kitti_on, frames).thresholds(rate, criterion)
    assert set(thresholds) == set(KITTI_SYSTEM.triples)
    for triple, threshold in thresholds.items():
        beyond = np.mean([threshold.exceeded(errors[triple]) for errors in frames])
        assert beyond == pytest.approx(rate, abs=1e-9 if criterion != "any" else 0.016)
        assert beyond <= rate + 1e-9


def test_the_thesis_looks_at_the_error_alone(kitti_on: FittedOn) -> None:
    table = table_of(kitti_on, samples(kitti_on))
    threshold = table.thresholds(0.02, "error")[0, 1, 3]
    errors = np.sort(table.shares[:, 1, 0])
    # 4 of 200 lie above: the threshold is the largest inlier.
    assert threshold == Threshold(errors[-5])
    assert not threshold.exceeded(DisparityError(0, 100, 9000))
    assert table.thresholds(0.02)[0, 1, 3].exceeded(DisparityError(0, 100, 9000))


@given(
    st.lists(st.tuples(*4 * [st.integers(0, 4)]), min_size=1, max_size=30),
    st.floats(0, 1),
)
def test_of_equal_samples_as_many_lie_beyond_as_can(
    rows: list[tuple[int, ...]], rate: float
) -> None:
    on = FittedOn(THREE_CAMERAS, {"name": "sgbm"}, (48.0, 384.0), {})
    values = np.array(rows) / 4
    threshold = ThresholdTable(on, values[:, None]).thresholds(rate)[0, 1, 2]
    # By trying: thresholds of brightness and of disproved points as many samples below the largest,
    # those of E and of holes a tenth as many.
    ranked = np.vstack([np.sort(values, axis=0)[::-1], np.full(4, -1.0)])
    counts = []
    for beyond in range(10 * len(values) + 1):
        ranks = np.minimum([beyond // 10, beyond // 10, beyond, beyond], len(values))
        counts.append(int((values > ranked[ranks, range(4)]).any(axis=1).sum()))
    allowed = max(count for count in counts if count <= rate * len(values) + 1e-6)
    assert (values > threshold.shares).any(axis=1).sum() == allowed


@pytest.mark.parametrize(("rate", "above"), [(0.0, 0), (0.01, 2), (0.05, 10)])
def test_thresholds_vouch_for_what_few_samples_can_show(
    kitti_on: FittedOn, rate: float, above: int
) -> None:
    table = table_of(kitti_on, samples(kitti_on))
    expected = beta.ppf(0.95, above + 1, 200 - above)
    assert table.vouched_rate(rate, "error") == pytest.approx(expected)
    assert table.vouched_rate(rate, "any") <= expected + 1e-12
    assert table.vouched_rate(rate, "error") > rate


def test_thresholds_below_every_sample_vouch_for_nothing(kitti_on: FittedOn) -> None:
    assert table_of(kitti_on, samples(kitti_on)).vouched_rate(1.0, "error") == 1


def test_detection_with_three_sensors() -> None:
    on = FittedOn(THREE_CAMERAS, {"name": "sgbm"}, (48.0, 384.0), {})
    shares = np.linspace(0.0, 0.099, 100)[:, None, None].repeat(4, axis=2)
    thresholds = ThresholdTable(on, shares).thresholds(0.01)
    sound, attacked = DisparityError(900, 9200, 10000), DisparityError(3000, 9200, 10000)
    hidden = DisparityError(0, 8000, 10000)
    dense, lit = (DisparityError(0, 9999, 10000, *two) for two in ((0.3, 0.0), (0.0, 0.3)))
    assert not detect_attack({(0, 1, 2): sound}, thresholds)
    assert detect_attack({(0, 1, 2): attacked}, thresholds)
    assert all(detect_attack({(0, 1, 2): shares}, thresholds) for shares in (hidden, dense, lit))
    with pytest.raises(ConfigurationError, match="one triple"):
        detect_attack(dict.fromkeys(KITTI_SYSTEM.triples, sound), thresholds)


def test_a_table_survives_its_file(tmp_path: Path, kitti_on: FittedOn) -> None:
    table = table_of(kitti_on, samples(kitti_on))
    path = tmp_path / "new" / "thresholds.json"
    table.write(path)
    again = read_threshold_table(path)
    assert again.on == kitti_on
    assert len(again) == 200
    np.testing.assert_array_equal(again.shares, table.shares)
    assert again.thresholds(0.01) == table.thresholds(0.01)
    with pytest.raises(DataError, match="left as it is"):
        table.write(path)
    table.write(path, overwrite=True)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda content: content.pop("shares"), "lacks 'shares'"),
        (lambda content: content.update(kind="likelihoods"), "expected 'thresholds'"),
        (lambda content: content.update(format=9), "format 9"),
        (lambda content: content["shares"][0].pop(), "damaged"),
        (lambda content: content["shares"][0][0].__setitem__(0, 1.5), "shares are from 0 to 1"),
        (lambda content: content["shares"][0][0].__setitem__(0, None), "damaged"),
        (lambda content: content["measures"].pop(), "expected"),
        (lambda content: content.update(shares=[]), "damaged"),
        (lambda content: content["fitted_on"].update(sensors=[2]), "damaged"),
        (lambda content: content["fitted_on"].update(scales=[384.0]), "1 scales for 3 cameras"),
        (lambda content: content["fitted_on"]["scales"].__setitem__(0, 0.0), "positive"),
        (lambda content: content["fitted_on"]["scales"].__setitem__(1, 1e6), "positive"),
        (lambda content: content["fitted_on"]["scales"].__setitem__(1, 2e9), "positive"),
    ],
)
def test_broken_files_are_named(
    tmp_path: Path, kitti_on: FittedOn, change: Callable[[dict[str, Any]], object], problem: str
) -> None:
    path = tmp_path / "thresholds.json"
    table_of(kitti_on, samples(kitti_on, 20)).write(path)
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))
    with pytest.raises(DataError, match=problem) as caught:
        read_threshold_table(path)
    assert str(path) in str(caught.value)


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no such file"):
        read_threshold_table(tmp_path / "missing.json")
    for text in ('{"kind": "thresh', "[]", "3", "\ufeff", ""):
        (tmp_path / "x.json").write_text(text)
        with pytest.raises(DataError, match=r"x\.json"):
            read_threshold_table(tmp_path / "x.json")


def test_thresholds_of_others_are_refused() -> None:
    calibration, depth = kitti_rig().calibration, PairDepth()
    on = fitted_on(KITTI_SYSTEM, depth, calibration, {"suite": "raw", "count": 2, "seed": 0})
    on.check(KITTI_SYSTEM, PairDepth("sgbm"), calibration)
    with pytest.raises(ConfigurationError, match="sensors lidar, 1, 3, 2, not lidar, 3, 2"):
        on.check(LIDAR_AND_TWO_CAMERAS, depth, calibration)
    with pytest.raises(ConfigurationError, match="psmnet"):
        on.check(KITTI_SYSTEM, PairDepth("psmnet"), calibration)
    with pytest.raises(ConfigurationError, match="nearest"):
        on.check(KITTI_SYSTEM, PairDepth(nearest=9.0), calibration)
    other = camera_rig([0.0, 0.8, 0.2, 0.5]).calibration
    system = SensorSystem((LIDAR, 1, 3, 2))
    with pytest.raises(ConfigurationError, match="stand otherwise"):
        on.check(system, depth, other)


def test_thresholds_know_the_weights_that_depth_had(tmp_path: Path) -> None:
    calibration, depth = kitti_rig().calibration, PairDepth("psmnet")
    on = fitted_on(KITTI_SYSTEM, depth, calibration, {})
    assert on.weights == depth.weights == weights_hash(PsmNetDepth("small", weights="shipped"))
    write_fitted(tmp_path / "on.json", "nothing", on, {}, overwrite=False)
    again, _ = read_fitted(tmp_path / "on.json", "nothing")
    again.check(KITTI_SYSTEM, PairDepth("psmnet"), calibration)
    with pytest.raises(ConfigurationError, match="fitted with the weights 00c0ffee"):
        replace(on, weights="00c0ffee" * 8).check(KITTI_SYSTEM, depth, calibration)
    with pytest.raises(ConfigurationError, match="weights unknown"):
        replace(on, weights=None).check(KITTI_SYSTEM, depth, calibration)
    assert "weights" not in fitted_on(KITTI_SYSTEM, PairDepth(), calibration, {}).to_json()


def test_whatever_a_file_holds_of_depth_is_taken_or_refused_by_the_file(
    kitti_on: FittedOn, tmp_path: Path
) -> None:
    path = tmp_path / "thresholds.json"
    write_fitted(path, "nothing", kitti_on, {}, overwrite=False)
    sound = json.loads(path.read_text())
    usual = {"name": "sgbm", "nearest": 3.5, "block": 5, "disparities": 64}
    refused = 0
    for wrong in (None, True, "a", "", -1, 0, 1e300, 10**18, [], [1], {}, {"a": 1}):
        for depth in (wrong, *({**usual, name: wrong} for name in (*usual, "left", "other"))):
            file = {**sound, "fitted_on": {**sound["fitted_on"], "depth": depth}}
            path.write_text(json.dumps(file))
            try:
                read_fitted(path, "nothing")
            except DataError as error:
                assert str(path) in str(error)  # noqa: PT017
                refused += 1
    assert refused > 70


@pytest.mark.parametrize("rate", [-0.1, 1.1, float("nan")])
def test_rates_that_are_none(kitti_on: FittedOn, rate: float) -> None:
    with pytest.raises(ConfigurationError, match="from 0 to 1"):
        table_of(kitti_on, samples(kitti_on, 5)).thresholds(rate)


def test_no_samples(kitti_on: FittedOn) -> None:
    with pytest.raises(ConfigurationError, match="each sample has 4 triples"):
        table_of(kitti_on, [])


def test_real_pairs_raise_the_threshold_of_brightness_and_no_other(
    kitti_on: FittedOn, tmp_path: Path
) -> None:
    table = table_of(kitti_on, samples(kitti_on))
    highest = float(table.shares[..., MEASURES.index("brightness")].max())
    for least in (1e-6, highest + 0.01):
        raised = replace(table, least_brightness=least)
        for criterion in CRITERIA:
            own = table.thresholds(0.01, criterion)
            for triple, limit in raised.thresholds(0.01, criterion).items():
                expected = own[triple].brightness
                if np.isfinite(expected):
                    expected = max(expected, least)
                assert limit == replace(own[triple], brightness=expected)
    assert {limit.brightness for limit in raised.thresholds(1.0, "brightness").values()} == {-1.0}
    raised.write(tmp_path / "raised.json")
    assert read_threshold_table(tmp_path / "raised.json").least_brightness == least
    table.write(tmp_path / "own.json")
    assert "least_brightness" not in (tmp_path / "own.json").read_text()
    assert read_threshold_table(tmp_path / "own.json").least_brightness == 0.0
    for wrong in (-0.1, 1.1, float("nan")):
        with pytest.raises(ConfigurationError, match="least_brightness"):
            replace(table, least_brightness=wrong)
    content = json.loads((tmp_path / "raised.json").read_text())
    (tmp_path / "wrong.json").write_text(json.dumps(content | {"least_brightness": "much"}))
    with pytest.raises(DataError):
        read_threshold_table(tmp_path / "wrong.json")


def test_a_raised_threshold_is_not_called_the_largest_sample(kitti_on: FittedOn) -> None:
    table = table_of(kitti_on, samples(kitti_on))
    assert SHARES["brightness"] not in ThresholdValidator(table, 0.05).remark
    raised = replace(table, least_brightness=0.99)
    assert SHARES["brightness"] not in ThresholdValidator(raised, 0.05).remark
    assert SHARES["brightness"] in ThresholdValidator(table, 0.001).remark
    assert SHARES["brightness"] not in ThresholdValidator(raised, 0.001).remark
