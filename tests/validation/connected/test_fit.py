"""What is fitted: it comes back from its file, holds for its rig, and can be stopped."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import beta

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.attacks.removed_object import RemovedObject
from avsec_gym.validation.connected.fit import (
    SHIPPED_FIT,
    ConnectedFit,
    read_connected_fit,
    write_connected_fit,
)
from avsec_gym.validation.connected.fitting import FittedInstants, fit_connected
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.scan_pattern import ScanPattern
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

_CARS = ((14.0, 3.0, 0.1), (20.0, -6.0, 0.4))


@pytest.fixture(scope="module")
def shipped() -> ConnectedFit:
    """The package's own."""
    return read_connected_fit(SHIPPED_FIT)


def test_the_shipped_fit_states_what_it_was_fitted_on(shipped: ConnectedFit) -> None:
    assert shipped.data["assets"] == "train"
    assert f"seed {shipped.data['seed']}" in shipped.origin
    assert len(shipped.clean_scores) == shipped.data["instants"]
    assert shipped.rates.through_absent > 10 * shipped.rates.through_present


def test_a_fit_comes_back_from_its_file(shipped: ConnectedFit, tmp_path: Path) -> None:
    path = tmp_path / "fit.json"
    unknown = replace(shipped, clean_scores=(-np.inf, 0.5, 2.0))
    write_connected_fit(path, unknown)
    assert read_connected_fit(path) == unknown
    with pytest.raises(DataError):
        write_connected_fit(path, shipped)


@pytest.mark.parametrize(("alarms", "above"), [(0.0, 0), (0.1, 3), (0.2, 6)])
def test_a_fit_vouches_for_what_its_instants_can_show(
    shipped: ConnectedFit, alarms: float, above: int
) -> None:
    thirty = replace(shipped, clean_scores=tuple(np.linspace(0.1, 3.0, 30)))
    assert thirty.vouched_alarms(alarms) == pytest.approx(beta.ppf(0.95, above + 1, 30 - above))
    # Scores that speak against an attack never alarm, however many may.
    quiet = replace(shipped, clean_scores=(-2.0, -1.0, -0.5))
    assert quiet.vouched_alarms(0.4) == pytest.approx(beta.ppf(0.95, 1, 3))


@pytest.mark.parametrize(
    "change",
    [
        {"kind": "thresholds"},
        {"format": 99},
        {"clean_scores": []},
        {"clean_distances": ["far"]},
        {"rates": {"support_present": 2.0}},
        {"pattern": None},
        {"epsilon": None},
        {"epsilon": 1e300},
        {"clean_scores": ["3"]},
        {"clean_scores": "123"},
        {"clean_scores": {"1": 2}},
        {"clean_distances": [-1.0]},
        {"rates": {}},
        {"margins": {}},
        {"see_through": 1e300},
        {"calibration": {"slope": 1e300, "offset": 0.0}},
    ],
)
def test_a_damaged_file_is_refused(
    change: dict[str, object], shipped: ConnectedFit, tmp_path: Path
) -> None:
    path = tmp_path / "fit.json"
    write_connected_fit(path, shipped)
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(DataError):
        read_connected_fit(path)


@pytest.mark.parametrize("part", ["pattern", "rates", "margins", "calibration", "of_distance"])
@pytest.mark.parametrize("wrong", [None, True, "3", 1e300, -1e300, [], {}])
def test_each_number_of_a_file_is_checked(
    part: str, wrong: object, shipped: ConnectedFit, tmp_path: Path
) -> None:
    path = tmp_path / "fit.json"
    write_connected_fit(path, shipped)
    sound = json.loads(path.read_text())
    for name in sound[part]:
        path.write_text(json.dumps(sound | {part: sound[part] | {name: wrong}}))
        with pytest.raises(DataError, match=r"fit\.json"):
            read_connected_fit(path)


def test_thresholds_are_order_statistics_of_what_was_attack_free(shipped: ConnectedFit) -> None:
    fit = replace(shipped, clean_scores=(1.0, 2.0, 3.0, 4.0), clean_distances=(0.1, 0.2, 0.3, 0.4))

    def alarms(share: float) -> list[bool]:
        constants = fit.constants(alarms=share)
        chance = constants.rule.calibration.probability(fit.clean_scores)
        return (chance >= constants.rule.alarm).tolist()

    assert alarms(0.0) == [False, False, False, False]
    assert alarms(0.25) == [False, False, False, True]
    assert alarms(0.5) == [False, False, True, True]
    assert fit.constants(rate=0.25).theta == 0.3
    # What speaks against an attack is no alarm, however many may be false.
    against = replace(fit, clean_scores=(-5.0, -4.0)).constants(alarms=0.9)
    assert against.rule.calibration.probability(-1.0) < against.rule.alarm
    with pytest.raises(ConfigurationError, match="false alarms"):
        fit.constants(alarms=1.0)


def test_another_lidar_is_refused(
    shipped: ConnectedFit, street: Callable[..., list[VehicleScan]]
) -> None:
    other = replace(shipped, pattern=ScanPattern(1.33, -30.0))
    scans = street((), (), ())
    shipped.check(scans)
    with pytest.raises(ConfigurationError, match="fit on clean instants"):
        other.check(scans)
    other.check([VehicleScan(np.zeros((0, 4), np.float32), np.eye(4))])


@pytest.mark.slow
def test_a_fit_goes_on_where_it_was_stopped(
    street: Callable[..., list[VehicleScan]], tmp_path: Path
) -> None:
    scans = tuple(street(_CARS, _CARS, _CARS))
    instants = [RecordedInstant(f"{number:06d}", scans) for number in range(6)]
    samples = tmp_path / "samples.jsonl"
    seen: list[tuple[int, int]] = []
    on = FittedInstants({"folder": "street"})
    first = fit_connected(
        instants, 6, on, samples=samples, on_progress=lambda done, total: seen.append((done, total))
    )
    assert seen[-1] == (6, 6)
    assert first.data["instants"] == 6
    # On a plain, rays pass through what is not there, and end on what is.
    assert first.rates.support_present > 0.9
    assert first.rates.through_absent > 0.7
    assert first.pattern.spacing == pytest.approx(26.8 / 63, rel=0.1)

    class Refuses(RemovedObject):
        def attack(self, instant: RecordedInstant, seed: object = 0) -> None:
            raise AssertionError("measured twice")

    again = fit_connected(instants, 6, replace(on, attacks=(Refuses(),)), samples=samples)
    assert again == first


def test_too_little_is_an_error_that_says_what_to_do() -> None:
    empty = VehicleScan(np.zeros((0, 4), np.float32), np.eye(4))
    nothing = [RecordedInstant("000000", (empty, empty))]
    with pytest.raises(DataError, match="could be attacked"):
        fit_connected(nothing, 1, FittedInstants())
