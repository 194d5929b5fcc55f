"""Validators name the camera that is covered, and none where none is."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import beta

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.registry import make
from avsec_gym.rig import kitti_rig
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.compromised_sensors import Untrusted
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.evidence import gather_evidence
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import fitted_on
from avsec_gym.validation.fitting import CleanFrames, fit_threshold_table
from avsec_gym.validation.likelihood.likelihood_fit import LikelihoodSamples, fit_likelihood
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.recordings import RecordedFrame
from avsec_gym.validation.response import Response, trusted_frame
from avsec_gym.validation.state_posterior import SensorStatus, state_vectors
from avsec_gym.validation.threshold_validator import ThresholdValidator
from avsec_gym.validation.thresholds import Criterion, ThresholdTable
from avsec_gym.validation.validator import Validator

SYSTEM = SensorSystem((LIDAR, 2, 1, 0))
WallOf = Callable[[int], SensorFrame]


def spoiled(frame: SensorFrame, sensors: set[int | str], seed: int = 0) -> SensorFrame:
    """Other dots in a third of a camera's image or more; the scan's middle 3 m nearer."""
    rng = np.random.default_rng(seed)
    for sensor in sensors - {LIDAR}:
        image = frame.image(int(sensor)).copy()
        left, width = rng.integers(40, 100), rng.integers(80, 110)
        image[:, left : left + width] = rng.integers(0, 256, (120, width, 1), np.uint8)
        frame = frame.with_image(int(sensor), image)
    if LIDAR in sensors:
        points = frame.points.copy()
        points[np.abs(points[:, 1]) < rng.uniform(1.0, 2.0), 0] -= 3.0
        frame = frame.with_points(points)
    return frame


@pytest.fixture(scope="module")
def table(wall_of: WallOf) -> ThresholdTable:
    frames = [RecordedFrame(str(seed), partial(wall_of, seed)) for seed in range(20)]
    return fit_threshold_table(CleanFrames(frames, SYSTEM, PairDepth()))


@pytest.mark.parametrize("attacked", [set(), *map(set, combinations(SYSTEM.sensors, 1))], ids=str)
# A fresh wall may exceed a threshold of 20 others; one of the 20 cannot.
def test_algorithm_2_names_the_attacked_sensor(
    wall_of: WallOf, table: ThresholdTable, attacked: set[int | str]
) -> None:
    validator = ThresholdValidator(table, rate=0.0)
    assert isinstance(validator, Validator)
    found = validator.validate(spoiled(wall_of(3), attacked))
    assert found.alarm == bool(attacked)
    assert found.attacked == attacked
    assert set(found.statuses) == set(SYSTEM.sensors)


def test_beyond_the_limit_what_cannot_be_told_is_said(
    wall_of: WallOf, table: ThresholdTable
) -> None:
    every = ThresholdValidator(table, rate=0.0).validate(spoiled(wall_of(40), set(SYSTEM.sensors)))
    assert every.alarm
    assert SensorStatus.CANNOT_TELL in every.statuses.values()


def table_with(frame: SensorFrame, beyond: set[tuple[int, int, int]]) -> ThresholdTable:
    """Of one clean frame, in which these triples had no error at all, and others every error."""
    on = fitted_on(SYSTEM, PairDepth(), frame.calibration, {})
    shares = [np.zeros(4) if triple in beyond else np.ones(4) for triple in SYSTEM.triples]
    return ThresholdTable(on, np.array([shares]))


def test_an_error_that_no_sensor_explains_is_not_kept_quiet(wall_of: WallOf) -> None:
    """Only e_{1,2,3} is 1: S_1 and S_2 agree with S_0, but not with each other."""
    wall = wall_of(0)
    found = ThresholdValidator(table_with(wall, {(1, 2, 3)}), rate=0.0).validate(wall)
    assert found.alarm
    assert not found.attacked
    assert found.statuses[LIDAR] == SensorStatus.SOUND
    assert {found.statuses[sensor] for sensor in (0, 1, 2)} == {SensorStatus.CANNOT_TELL}
    # Then all that nothing clears is left away, and a camera detector stops.
    with pytest.raises(Untrusted):
        trusted_frame(wall, found, Response.DROP).image(2)


def test_what_raised_the_alarm_is_told_the_farthest_beyond_first(
    wall_of: WallOf, table: ThresholdTable
) -> None:
    wall = wall_of(3)
    assert ThresholdValidator(table, rate=0.0).validate(wall).exceeded == ()
    found = ThresholdValidator(table, rate=0.0).validate(spoiled(wall, {1}))
    assert {excess.triple for excess in found.exceeded} == {(0, 2, 3), (1, 2, 3)}
    for excess in found.exceeded:
        assert excess.value == getattr(found.errors[excess.triple], excess.share) > excess.threshold
    times = [excess.times for excess in found.exceeded]
    assert times == sorted(times, reverse=True)
    # The thesis' criterion knows E alone.
    of_e = ThresholdValidator(table, rate=0.0, criterion="error").validate(spoiled(wall, {1}))
    assert (
        {excess.share for excess in of_e.exceeded}
        == {"error"}
        < {excess.share for excess in found.exceeded}
    )


@pytest.mark.parametrize(
    ("count", "rate", "criterion", "told"),
    [
        (99, 0.01, "any", "E, holes, densest window, other brightness"),
        (99, 0.01, "error", "E"),
        (600, 0.01, "any", "E, holes"),
        (600, 0.01, "error", ""),
        (160, 0.01, "any", "E, holes, densest window, other brightness"),
        (200, 0.01, "any", "E, holes"),
        (2200, 0.01, "any", ""),
        (99, 0.0, "any", ""),
    ],
)
def test_too_few_clean_frames_for_the_rate_are_said(
    wall_of: WallOf, count: int, rate: float, criterion: Criterion, told: str
) -> None:
    """With any, the samples beyond one of four shares are r of all, a tenth of them beyond E."""
    on = fitted_on(SYSTEM, PairDepth(), wall_of(0).calibration, {})
    shares = np.random.default_rng(0).uniform(size=(count, len(SYSTEM.triples), 4))
    remark = ThresholdValidator(ThresholdTable(on, shares), rate, criterion).remark
    if told:
        assert f"more false alarms than r = {rate}: of {count} clean frames" in remark
        assert f"the thresholds of {told} are the largest" in remark
        enough = "up to 200, for E and holes up to 2,200" if criterion == "any" else "100 or more"
        assert remark.endswith(f"it takes {enough}")
    else:
        assert remark == ""


def test_a_fit_says_what_it_vouches_for(wall_of: WallOf) -> None:
    on = fitted_on(SYSTEM, PairDepth(), wall_of(0).calibration, {})
    shares = np.random.default_rng(0).uniform(size=(600, len(SYSTEM.triples), 4))
    said = ThresholdValidator(ThresholdTable(on, shares), 0.01, "error").vouched
    assert "600 clean frames at r = 0.01" in said
    # Six of 600 lie beyond: the 95 % quantile of Beta(7, 594).
    assert f"of {beta.ppf(0.95, 7, 594):.2g} at most" in said


def test_where_no_two_sensors_agree_none_is_named(wall_of: WallOf) -> None:
    """More than n - 2 are attacked: that S_n was dropped first says nothing of it."""
    wall = wall_of(0)
    said = ThresholdValidator(table_with(wall, set(SYSTEM.triples)), rate=0.0).validate(wall)
    assert said.alarm
    assert not said.attacked
    assert set(said.statuses.values()) == {SensorStatus.CANNOT_TELL}


def test_maps_are_found_together_and_only_those_that_are_asked_for(
    wall_of: WallOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    together: list[list[tuple[int, int]]] = []
    find = DisparityMaps.find

    def recorded(self: DisparityMaps, pairs: Iterable[tuple[int, int]], threads: int = 2) -> None:
        known = dict(self._known)
        find(self, pairs, threads)
        together.append(sorted(self._known.keys() - known.keys()))

    monkeypatch.setattr(DisparityMaps, "find", recorded)
    wall = wall_of(0)
    for beyond, expected in (
        (set(), [(0, 3), (1, 2), (1, 3), (2, 3)]),
        ({t for t in SYSTEM.triples if t[2] == 3}, [(0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]),
    ):
        together.clear()
        said = ThresholdValidator(table_with(wall, beyond), rate=0.0).validate(wall)
        assert sorted(said.errors.maps._known) == expected
        assert sorted(pair for found in together for pair in found) == expected
        assert sum(map(bool, together)) == (2 if beyond else 1)


def test_three_sensors_raise_an_alarm_and_name_none(wall_of: WallOf, tmp_path: Path) -> None:
    system = SensorSystem((LIDAR, 1, 0))
    frames = [RecordedFrame(str(seed), partial(wall_of, seed)) for seed in range(5)]
    path = tmp_path / "thresholds.json"
    fit_threshold_table(CleanFrames(frames, system, PairDepth())).write(path)
    validator = make("validator", {"name": "thresholds", "thresholds": str(path), "rate": 0.0})
    found = validator.validate(spoiled(wall_of(40), {1}))
    assert found.alarm
    assert not found.attacked
    assert set(found.statuses.values()) == {SensorStatus.CANNOT_TELL}
    clean = validator.validate(wall_of(2))
    assert not clean.alarm
    assert set(clean.statuses.values()) == {SensorStatus.SOUND}


def test_another_rig_or_a_missing_sensor_is_refused(wall_of: WallOf, table: ThresholdTable) -> None:
    validator = ThresholdValidator(table)
    wall = wall_of(0)
    other = SensorFrame(wall.id, kitti_rig().calibration, dict(wall.images), wall.points)
    with pytest.raises(ConfigurationError):
        validator.validate(other)
    images = {0: wall.image(0), 2: wall.image(2)}
    with pytest.raises(DataError, match="camera 1"):
        validator.validate(SensorFrame(wall.id, wall.calibration, images, wall.points))


@pytest.mark.slow
def test_the_likelihood_names_up_to_n_minus_2_with_probabilities(wall_of: WallOf) -> None:
    states = [state for state in state_vectors(4) if state.sum() <= 2]
    evidence, truth, frames = [], [], []
    for seed in range(20):
        for number, state in enumerate(states):
            sensors = {s for s, hit in zip(SYSTEM.sensors, state, strict=True) if hit}
            frame = spoiled(wall_of(seed), sensors, seed=100 * seed + number)
            evidence.append(gather_evidence(DisparityErrors(DisparityMaps(frame, SYSTEM))))
            truth.append(state)
            frames.append(seed)
    # Triples of three attacked sensors are a part of the model, too.
    for seed in range(20):
        for state in state_vectors(4)[[7, 11, 13, 14]]:
            sensors = {s for s, hit in zip(SYSTEM.sensors, state, strict=True) if hit}
            frame = spoiled(wall_of(seed), sensors, seed=7000 + seed)
            evidence.append(gather_evidence(DisparityErrors(DisparityMaps(frame, SYSTEM))))
            truth.append(state)
            frames.append(seed)
    on = fitted_on(SYSTEM, PairDepth(), wall_of(0).calibration, {"walls": 20})
    samples = LikelihoodSamples(np.array(evidence), np.array(truth), np.array(frames))
    validator = LikelihoodValidator(fit_likelihood(on, samples), rate=0.0, certainty=None)
    assert isinstance(validator, Validator)
    right = 0
    for number, state in enumerate(states):
        sensors = {s for s, hit in zip(SYSTEM.sensors, state, strict=True) if hit}
        found = validator.validate(spoiled(wall_of(50 + number), sensors, seed=9000 + number))
        right += found.attacked == sensors
        assert found.probabilities is not None
        assert set(found.probabilities) == set(SYSTEM.sensors)
    assert right >= len(states) - 1
