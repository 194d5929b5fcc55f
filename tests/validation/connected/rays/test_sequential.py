"""The test over frames: small evidence adds up, and false alarms stay as rare as was asked."""

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.validation.connected.rays.sequential import (
    SequentialTest as PageTest,
)
from avsec_gym.validation.connected.rays.sequential import (
    bound_on_false_alarms,
    fit_limit,
    fitted_correlation,
    lasting_test,
    share_of_alarms,
    windows,
)


def alarms_apart(test: PageTest, scores: list[Floats]) -> Share:
    """Each window of a drive of its own."""
    return share_of_alarms(test, scores, list(map(str, range(len(scores)))))


def test_sums_by_hand() -> None:
    sums = PageTest(limit=4.0, allowance=0.5, clip=3.0).sums([1.5, -9.0, 2.5, np.nan, 9.0])
    assert sums.tolist() == [1.0, 0.0, 2.0, 2.0, 4.5]


def test_an_alarm_comes_with_the_first_frame_at_the_limit() -> None:
    page = PageTest(limit=4.0, allowance=0.0, clip=3.0)
    assert page.alarm([2.0, 2.0, -5.0]) == 1
    assert page.alarm([2.0, -2.0, 2.0, -2.0]) is None


def test_one_frame_alone_cannot_alarm_below_the_clip() -> None:
    assert PageTest(limit=5.0, clip=4.0).alarm([100.0]) is None


def test_frames_that_are_alike_count_for_less() -> None:
    """What n frames inform of is the inverse of the variance of the best estimate of their mean."""
    frames, alike = 10, 0.6
    lag = np.abs(np.subtract.outer(np.arange(frames), np.arange(frames)))
    information = np.linalg.inv(alike**lag).sum()
    sums = PageTest(correlation=alike).sums(np.ones(frames))
    assert sums[-1] == pytest.approx(information)
    assert sums[0] == 1.0


def test_the_correlation_of_frames_is_found() -> None:
    rng, scores = np.random.default_rng(6), np.empty((400, 30))
    scores[:, 0] = rng.normal(0, 1, 400)
    for frame in range(1, 30):
        scores[:, frame] = 0.7 * scores[:, frame - 1] + rng.normal(0, 0.51**0.5, 400)
    gaps = np.where(rng.random(scores.shape) < 0.3, -np.inf, scores)
    assert fitted_correlation(list(gaps)) == pytest.approx(0.7, abs=0.03)
    assert fitted_correlation(list(rng.normal(0, 1, (200, 30)))) == pytest.approx(0, abs=0.05)
    assert fitted_correlation([np.ones(5)]) == fitted_correlation([]) == 0.0


@pytest.mark.parametrize("correlation", [-0.1, 1.0, np.nan])
def test_a_correlation_that_cannot_be_is_refused(correlation: float) -> None:
    with pytest.raises(ConfigurationError, match="correlation"):
        PageTest(correlation=correlation)


def test_windows_do_not_overlap() -> None:
    assert [each.tolist() for each in windows(np.arange(7.0), 3)] == [[0, 1, 2], [3, 4, 5]]


def test_the_limit_of_a_rate_lets_so_many_windows_alarm() -> None:
    rng = np.random.default_rng(0)
    fitted_on = windows(rng.normal(-0.5, 1.0, 40_000), 10)
    page = fit_limit(fitted_on, rate=0.01)
    assert alarms_apart(page, fitted_on).count == 40
    judged = alarms_apart(page, windows(rng.normal(-0.5, 1.0, 40_000), 10))
    assert judged.rate == pytest.approx(0.01, abs=0.006)
    low, high = judged.interval
    assert low < judged.rate < high
    # An attack of one standard deviation in every frame is found in nearly every window.
    attacked = windows(rng.normal(1.0, 1.0, 10_000), 10)
    assert alarms_apart(page, attacked).count > 900


def test_no_window_alarms_at_the_rate_zero() -> None:
    attack_free = windows(np.random.default_rng(2).normal(0, 1, 500), 10)
    assert alarms_apart(fit_limit(attack_free, 0.0), attack_free).count == 0


def test_windows_of_one_drive_count_less() -> None:
    quiet, loud = [np.full(10, -1.0)] * 10, [np.full(10, 5.0)] * 10
    of_two_drives = share_of_alarms(PageTest(), [*quiet, *loud], ["a"] * 10 + ["b"] * 10)
    apart = share_of_alarms(PageTest(), [*quiet, *loud], list(map(str, range(20))))
    assert of_two_drives.rate == apart.rate == 0.5
    assert of_two_drives.interval == pytest.approx(wilson_interval(1, 2))
    assert apart.interval == pytest.approx(wilson_interval(10, 20))


def test_what_is_no_test_is_refused() -> None:
    with pytest.raises(ConfigurationError):
        PageTest(limit=0.0)
    with pytest.raises(DataError):
        fit_limit([], 0.01)


def test_frames_in_which_nothing_was_decidable_leave_the_sum_as_it_is() -> None:
    assert PageTest().sums([3.0, np.nan, -np.inf, 3.0]).tolist() == [3.0, 3.0, 3.0, 6.0]


@pytest.mark.parametrize("allowance", [-6.0, 6.0, np.nan, np.inf])
def test_an_allowance_beyond_the_clip_is_refused(allowance: float) -> None:
    with pytest.raises(ConfigurationError, match="allowance"):
        PageTest(allowance=allowance)


@pytest.mark.parametrize("alike", [0.0, 0.9, 1.0])
def test_from_single_frames_no_more_windows_alarm_than_was_asked(alike: float) -> None:
    """Simulated drives whose frames are independent, drift, or never change."""
    rng = np.random.default_rng(4)
    page = lasting_test(rng.normal(0.0, 2.0, 5_000), 10, rate=0.1)
    scores = np.empty((4_000, 10))
    scores[:, 0] = rng.normal(0.0, 2.0, 4_000)
    for frame in range(1, 10):
        fresh = rng.normal(0.0, 2.0 * np.sqrt(1 - alike**2), 4_000)
        scores[:, frame] = alike * scores[:, frame - 1] + fresh
    alarms = alarms_apart(page, list(scores))
    assert alarms.rate <= 0.1 + 0.012
    if alike == 1.0:
        assert alarms.rate == pytest.approx(0.1, abs=0.012)
    # What lasts is found, at half of the window's length at the earliest.
    assert page.alarm(np.full(10, 50.0)) == 5


def test_what_hardly_speaks_for_an_attack_never_adds_up() -> None:
    page = lasting_test([-5.0, -4.0, -np.inf], 10, rate=0.1)
    assert page.alarm(np.full(10, 0.4)) is None
    assert page.alarm(np.full(10, 1.1)) is not None


@pytest.mark.slow
def test_the_bound_holds_for_nineteen_sets_of_drives_in_twenty() -> None:
    """Windows of a drive share an offset; each drive has an alarm with a known probability."""
    rng = np.random.default_rng(5)
    names, holds, chance = [f"{drive}" for drive in range(60) for _ in range(5)], 0, 0.05
    for _ in range(400):
        loud = rng.random(60) < chance
        scores = [np.full(10, 5.0 if loud[int(name)] else -1.0) for name in names]
        holds += bound_on_false_alarms(PageTest(), scores, names) >= chance
    assert holds / 400 >= 0.95 - 0.035


def test_no_windows_have_no_bound() -> None:
    with pytest.raises(ConfigurationError):
        bound_on_false_alarms(PageTest(), [], [])
    with pytest.raises(ConfigurationError, match="frames"):
        lasting_test([1.0], 1, 0.1)
    with pytest.raises(DataError):
        lasting_test([], 10, 0.1)
