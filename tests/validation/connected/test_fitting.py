"""What is fitted to measured instants, from a file of measurements made by hand."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.fit import ConnectedFit
from avsec_gym.validation.connected.fitting import FittedInstants, fit_connected
from avsec_gym.validation.connected.rays.decision import DecisionRule, decide
from avsec_gym.validation.connected.rays.fitting import LabelledCounts, fit_calibration, fit_rates
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

VEHICLES, REGIONS = 3, 4


def _counts(random: np.random.Generator, victim: int | None, kind: str) -> np.ndarray:
    """Testimonies of each vehicle about each other's claims; those about the victim contradict."""
    counts = np.zeros((REGIONS, VEHICLES, VEHICLES, 3), int)
    for region in range(REGIONS):
        for claimer in range(VEHICLES):
            for witness in range(VEHICLES):
                if claimer == witness:
                    continue
                about = claimer if kind == "ghost" else witness
                gone = victim is not None and about == victim
                chances = [0.05, 0.85, 0.1] if gone else [0.9, 0.08, 0.02]
                counts[region, claimer, witness] = random.multinomial(
                    random.integers(8, 30), chances
                )
    return counts


def _listed(counts: np.ndarray) -> list[list[int]]:
    """As a file of measurements has them: the number of regions, then a row for each testimony."""
    rows = [
        [region, claimer, witness, *map(int, counts[region, claimer, witness])]
        for region, claimer, witness in np.ndindex(*counts.shape[:3])
        if counts[region, claimer, witness].any()
    ]
    return [[len(counts)], *rows]


def _measured(seed: int = 0, instants: int = 6) -> tuple[list[dict[str, Any]], list[Any]]:
    """Rows of a file, and the counts in them: attack-free, then (kind, victim, counts)."""
    random = np.random.default_rng(seed)
    rows, counts = [], []
    for number in range(instants):
        clean = _counts(random, None, "ghost")
        attacks = [("ghost", number % 3), ("removal", (number + 1) % 3)]
        attacked = [(kind, victim, _counts(random, victim, kind)) for kind, victim in attacks]
        counts.append((clean, attacked))
        rows.append(
            {
                "id": f"{number:06d}",
                "vehicles": VEHICLES,
                "pattern": [[0.4 + 0.01 * number, -24.8]] * VEHICLES,
                "epsilon": None if number == 0 else 0.01 * number,
                "clean": _listed(clean),
                "clean_distances": [0.2 + 0.05 * number, 0.3],
                "pairs": [0.5, 0.1 * number],
                "attacked": [
                    {
                        "kind": kind,
                        "victim": victim,
                        "counts": _listed(each),
                        "distances": [1.5 + 0.1 * number],
                    }
                    for kind, victim, each in attacked
                ],
            }
        )
    return rows, counts


def _fitted(rows: list[dict[str, Any]], folder: Path) -> ConnectedFit:
    samples = folder / "samples.jsonl"
    samples.write_text("".join(json.dumps(row) + "\n" for row in rows))
    return fit_connected([], 0, FittedInstants({"folder": "by hand"}), samples=samples)


def test_rates_are_of_testimonies_about_the_victim_and_of_attack_free_ones(tmp_path: Path) -> None:
    rows, counts = _measured()
    absent = [
        (each[:, victim] if kind == "ghost" else each[:, :, victim]).reshape(-1, 3)
        for _, attacked in counts
        for kind, victim, each in attacked
    ]
    present = [clean.reshape(-1, 3) for clean, _ in counts]
    fit = _fitted(rows, tmp_path)
    assert fit.rates == fit_rates(LabelledCounts(np.concatenate(present), np.concatenate(absent)))
    assert fit.rates.through_absent == pytest.approx(0.85, abs=0.03)
    assert fit.rates.support_present == pytest.approx(0.9, abs=0.03)
    assert fit.data == {"folder": "by hand", "instants": 6, "attacked": 12}


def test_the_odds_of_see_through_things_are_those_with_the_least_loss(tmp_path: Path) -> None:
    rows, counts = _measured()
    # In one clean region, all contradict one another: a fence.
    counts[2][0][1] = _counts(np.random.default_rng(1), 0, "ghost")[0, 0, 1]
    rows[2]["clean"] = _listed(counts[2][0])
    fit = _fitted(rows, tmp_path)
    losses = {}
    for odds in (-4.0, -3.0, -2.0, -1.0, 0.0):
        rule = DecisionRule(see_through=odds)
        clean = np.concatenate([decide(each, fit.rates, rule).score for each, _ in counts])
        attacked = np.concatenate(
            [decide(each, fit.rates, rule).score for _, some in counts for _, _, each in some]
        )
        calibration = fit_calibration(
            [*clean, *attacked], [False] * len(clean) + [True] * len(attacked)
        )
        chance = np.r_[1 - calibration.probability(clean), calibration.probability(attacked)]
        losses[odds] = (-np.log(chance).mean(), calibration)
    assert len({loss for loss, _ in losses.values()}) > 1
    best = min(losses, key=lambda odds: losses[odds][0])
    assert fit.see_through == best
    assert fit.calibration == losses[best][1]
    rule = DecisionRule(see_through=best)
    highest = sorted(decide(clean, fit.rates, rule).score.max() for clean, _ in counts)
    assert fit.clean_scores == pytest.approx(highest, abs=1e-4)


def test_surfaces_are_fitted_to_the_distances(tmp_path: Path) -> None:
    rows, _ = _measured()
    fit = _fitted(rows, tmp_path)
    assert fit.epsilon == pytest.approx(0.03)
    assert fit.pattern.spacing == pytest.approx(0.425, abs=1e-3)
    assert fit.pattern.lowest == -24.8
    pairs = sorted(pair for row in rows for pair in row["pairs"])
    assert fit.clean_distances == pytest.approx(pairs)
    clean = [each for row in rows for each in row["clean_distances"]]
    attacked = [each for row in rows for some in row["attacked"] for each in some["distances"]]
    truth = [False] * len(clean) + [True] * len(attacked)
    assert fit.of_distance == fit_calibration([*clean, *attacked], truth)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"attacked": []}, "could be attacked"),
        ({"pattern": []}, "No surfaces"),
        ({"epsilon": None}, "No surfaces"),
        ({"clean_distances": []}, "No surfaces"),
        ({"clean": [[4]]}, "decidable testimonies of what is there"),
    ],
)
def test_too_little_of_anything_is_an_error(
    change: dict[str, Any], problem: str, tmp_path: Path
) -> None:
    rows, _ = _measured()
    with pytest.raises(DataError, match=problem):
        _fitted([{**row, **change} for row in rows], tmp_path)


def test_what_is_measured_of_an_instant_is_kept_in_full(
    street: Callable[..., list[VehicleScan]], tmp_path: Path
) -> None:
    cars = ((14.0, 3.0, 0.1), (20.0, -6.0, 0.4))
    instant = RecordedInstant("000000", tuple(street(cars, cars, cars)))
    samples = tmp_path / "samples.jsonl"
    on = FittedInstants(seed=4)
    with pytest.raises(DataError, match="decidable testimonies"):  # Of one instant.
        fit_connected([instant], 1, on, samples=samples)
    (row,) = map(json.loads, samples.read_text().splitlines())
    validator = ConnectedValidator(ConnectedConstants(margins=on.margins))
    clean = validator.validate(instant.scans)
    assert clean.counts is not None
    assert row["clean"] == _listed(clean.counts)
    assert len(row["clean"]) > 5
    distances = replace(validator, method="surfaces").validate(instant.scans).distances
    assert distances is not None
    compared = [each for each in distances if np.isfinite(each).any()]
    assert row["clean_distances"] == [pytest.approx(np.nanmax(e), abs=1e-3) for e in compared]
    pairs = [each[i, j] for each in distances for i in range(3) for j in range(i)]
    finite = sorted(each for each in pairs if np.isfinite(each))
    assert sorted(row["pairs"]) == pytest.approx(finite, abs=1e-3)
    assert [each["kind"] for each in row["attacked"]] == ["ghost", "removal"]
    for index, (attack, kept) in enumerate(zip(on.attacks, row["attacked"], strict=True)):
        attacked = attack.attack(instant, (4, 0, index))
        assert attacked is not None
        assert kept["victim"] == attacked.victim
        result = validator.validate(attacked.instant.scans)
        assert result.counts is not None
        assert kept["counts"] == _listed(result.counts[attacked.regions(result.regions)])
