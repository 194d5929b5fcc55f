"""Validators of several vehicles in the benchmark: what is counted of detections and of names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.benchmark import connected_instants, entry_sets
from avsec_gym.benchmark.entry import Entry, read_entry
from avsec_gym.benchmark.making import entered
from avsec_gym.benchmark.protocol import Entered
from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind, make, names, register
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.attacks.removed_object import RemovedObject
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, NO_ATTACK
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.conftest import CARS, POSES, scan_of

TRIES = 2
"""Attempts of an adaptive attacker, in place of the benchmark's."""
SELDOM = ("another", "cannot tell", "nothing")
"""Answers that only the slow tests give."""


class Streets:
    """Three vehicles on streets of a few cars, in place of the frozen instants."""

    seed, digest = 3, "streets"

    def numbers(self, *, quick: bool = False) -> list[int]:
        return [0] if quick else [0, 1, 2]

    def instant(self, number: int) -> RecordedInstant:
        scans = tuple(scan_of(pose, *CARS[: 2 + number]) for pose in POSES)
        return RecordedInstant(f"{number:06d}", scans)

    def attacks(self, number: int, attempt: tuple[int, ...] = ()) -> list[AttackedInstant]:
        instant = self.instant(number)
        found = [
            attack.attack(instant, (self.seed, number, index, *attempt))
            for index, attack in enumerate((PastedObject(), RemovedObject()))
        ]
        return [each for each in found if each is not None]


@pytest.fixture(autouse=True)
def streets(monkeypatch: pytest.MonkeyPatch) -> Streets:
    found = Streets()
    monkeypatch.setattr(connected_instants, "INSTANT_TRIES", TRIES)
    for module in (connected_instants, entry_sets):
        monkeypatch.setattr(module, "frozen_instants", lambda: found)
    return found


@dataclass(frozen=True)
class Judged:
    regions: Regions
    score: Any
    named: Any


@dataclass(frozen=True)
class Informed:
    """Knows which scan was tampered with and where, and gives one answer.

    Of an adaptive attacker's attempts it knows the first ones.
    """

    answer: str = "victim"
    attempts: int = 1

    def validate(self, scans: Sequence[VehicleScan], *, id: str = "") -> Judged:
        known = [(), *((attempt,) for attempt in range(1, self.attempts))]
        attacks = [each for attempt in known for each in Streets().attacks(int(id), attempt)]
        for attacked in attacks:
            before = attacked.instant.scans
            if all(np.array_equal(a.points, b.points) for a, b in zip(scans, before, strict=True)):
                named = {
                    "victim": attacked.victim,
                    "another": (attacked.victim + 1) % 3,
                    "cannot tell": CANNOT_TELL,
                    "nothing": NO_ATTACK,
                }[self.answer]
                return Judged(attacked.box, np.array([5.0]), np.array([named]))
        return Judged(Regions.empty(), np.zeros(0), np.zeros(0, np.int64))


class Nervous:
    """Names vehicle 0 somewhere far off, whatever the scans are."""

    def validate(self, scans: Sequence[VehicleScan], *, id: str = "") -> Judged:
        far = Regions(np.array([[900.0, 0.0, 0.0]]), np.ones((1, 3)), np.zeros(1))
        return Judged(far, np.array([1.0]), np.array([0]))


for _name, _validator in (("informed", Informed), ("nervous", Nervous)):
    if _name not in names(Kind.CONNECTED_VALIDATOR):
        register(Kind.CONNECTED_VALIDATOR, _name, _validator)


def made(part: Any, root: Path, **more: Any) -> Entry:
    return entered(Entered.VALIDATOR, part, root, workers=0, **more)


@pytest.mark.parametrize(
    "answer", ["victim", *(pytest.param(name, marks=pytest.mark.slow) for name in SELDOM)]
)
def test_every_answer_is_counted_as_what_it_is(
    streets: Streets, tmp_path: Path, answer: str
) -> None:
    entry = made({"name": "informed", "answer": answer}, tmp_path)
    assert (entry.rows, entry.drives, entry.weights, entry.skipped) == ([], [], {}, {})
    assert [(row.scenes, row.count) for row in entry.scenes] == [("connected", 3)]
    clean = entry.instant("unattacked")
    assert clean is not None
    assert (clean.instants, clean.alarms.count, clean.honest_named.count) == (3, 0, 0)
    assert clean.area is None
    attacks = [each for number in streets.numbers() for each in streets.attacks(number)]
    for kind in ("ghost", "removal"):
        row = entry.instant(kind)
        assert row is not None
        cases = sum(each.kind == kind for each in attacks)
        assert row.instants == cases > 0
        right, wrong, untold = (
            cases * (answer == each) for each in ("victim", "another", "cannot tell")
        )
        assert row.victim is not None
        assert row.another is not None
        assert row.cannot_tell is not None
        assert row.detected is not None
        assert (row.victim.count, row.another.count, row.cannot_tell.count) == (
            right, wrong, untold,
        )  # fmt: skip
        assert row.detected.count == row.alarms.count == right + wrong + untold
        assert row.honest_named.count == wrong
        # The score is high whatever is named; without an attack there is none.
        assert row.area is not None
        assert row.at_rate is not None
        assert row.decidable is not None
        assert row.decidable.count == row.at_rate.of > 0
        assert (row.area.value, row.at_rate.rate) == (1.0, 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("blind", [True, False])
def test_a_validator_that_is_blind_to_other_attacks_is_broken(tmp_path: Path, blind: bool) -> None:
    part = {"name": "informed", "attempts": 1 if blind else TRIES}
    entry = made(part, tmp_path)
    assert [row.setting for row in entry.adaptive] == ["ghost adaptive", "removal adaptive"]
    listed, under = entry.instant("ghost"), entry.instant("ghost adaptive")
    assert listed is not None
    assert under is not None
    assert listed.of_decidable is not None
    assert listed.of_decidable.rate == 1.0
    # Only attempts of which another vehicle can tell are kept, if there are any.
    assert under.decidable is not None
    assert listed.decidable is not None
    assert under.decidable.count >= listed.decidable.count
    ghost = entry.adaptive[0]
    assert (ghost.against, ghost.measure) == ("ghost", "detected")
    assert ghost.detected == under.of_decidable
    assert ghost.detected is not None
    assert ghost.detected.rate == (0.0 if blind else 1.0)
    assert entry.broken is blind
    again = read_entry(tmp_path / "entry.json")
    assert again.to_json() == entry.to_json()


def test_an_alarm_elsewhere_detects_nothing(tmp_path: Path) -> None:
    entry = made("nervous", tmp_path)
    for row in entry.instants:
        assert row.alarms.rate == 1.0
        if row.detected is not None and row.area is not None and row.at_rate is not None:
            assert (row.detected.count, row.at_rate.count, row.area.value) == (0, 0, 0.0)
    clean = entry.instant("unattacked")
    assert clean is not None
    assert clean.honest_named.rate == 1.0


@pytest.mark.slow
def test_the_packages_own_twice_the_same(streets: Streets, tmp_path: Path) -> None:
    entry = made("rays", tmp_path / "one")
    assert made("rays", tmp_path / "two").to_json() == entry.to_json()
    assert read_entry(tmp_path / "one/entry.json").to_json() == entry.to_json()
    own = make(Kind.CONNECTED_VALIDATOR, "rays")
    alarms = [own.validate(streets.instant(number).scans).alarm for number in streets.numbers()]
    clean = entry.instant("unattacked")
    assert clean is not None
    assert clean.alarms.count == sum(alarms)
    quick = made("rays", tmp_path / "quick", quick=True)
    assert quick.scenes[0].count == 1


def test_slips_are_reported_before_anything_is_made(tmp_path: Path) -> None:
    for part, message in (("ray", "Did you mean"), ({"name": "rays", "alarm": 0.2}, "alarm")):
        with pytest.raises(ConfigurationError, match=message):
            made(part, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_what_a_part_is_made_of() -> None:
    assert make(Kind.CONNECTED_VALIDATOR, "surfaces").method == "surfaces"
    strict = make(Kind.CONNECTED_VALIDATOR, {"name": "rays", "alarms": 0.0})
    usual = make(Kind.CONNECTED_VALIDATOR, "rays")
    assert strict.constants.rule.alarm >= usual.constants.rule.alarm
    with pytest.raises(ConfigurationError):
        make(Kind.CONNECTED_VALIDATOR, {"name": "rays", "alarms": 2.0})
