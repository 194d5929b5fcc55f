"""Attackers who know the method, or have less or more than one ghost: detected, and named?

Run ``python -m studies.chapter4.connected_attackers --json FILE``.  Each judged place is attacked
in all ways; thresholds are those of attack-free places of the training assets.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avsec_gym.console import progress
from avsec_gym.experiments.chapter4.settings import FITTED, FIVE, JUDGED, USUAL, Part
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.roc_curve import threshold_at
from avsec_gym.progress import Progress, no_progress
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.attacks.several_victims import (
    attack_several,
    with_the_same_ghost,
)
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.validator import ConnectedValidator
from studies.answer import answer
from studies.chapter4.usual_places import SEED, shipped_constants, usual, usual_places

VEHICLES = (USUAL.vehicles, FIVE.vehicles)
RATE = 0.03
"""Share of decidable attack-free regions of other places that exceed the threshold."""
Attacker = Callable[[RecordedInstant, tuple[int, int]], list[AttackedInstant]]
"""What an attacker makes of an instant, by a seed: each victim; the last one's instant has all."""


def _alone(attack: PastedObject) -> Attacker:
    return lambda instant, seed: attack_several(instant, [attack], seed)


def _two_victims(instant: RecordedInstant, seed: tuple[int, int]) -> list[AttackedInstant]:
    """Two vehicles with a ghost each, at places of their own."""
    done = attack_several(instant, [PastedObject(0), PastedObject(1)], seed)
    return done if len(done) == 2 else []


def _same_ghost(instant: RecordedInstant, seed: tuple[int, int]) -> list[AttackedInstant]:
    """One ghost at one place in the scans of two vehicles, which confirm each other."""
    first = PastedObject(0).attack(instant, seed)
    return [] if first is None else [first, with_the_same_ghost(first, 1)]


ATTACKERS: Mapping[str, Attacker] = {
    "anywhere": _alone(PastedObject()),
    "blind_spot": _alone(PastedObject(where="blind_spot")),
    "path": _alone(PastedObject(where="path")),
    "sun_2020": _alone(PastedObject(laser="sun_2020")),
    "cao_2019": _alone(PastedObject(laser="cao_2019")),
    "two_victims": _two_victims,
    "same_ghost": _same_ghost,
}


@dataclass(frozen=True)
class AttackerRow:
    """Attacks of one kind on so many vehicles; each ghost of two victims is an attack.

    Args:
        attacker: One of `ATTACKERS`.
        vehicles: Number of vehicles.
        points: Median number of points that were placed.
        covered: The attacks that a proposed region covers, of all.
        decidable: The attacks with a region of which some vehicle bears witness, of all.
        end_to_end: The attacks that are detected, of all: whatever is not decidable is a miss.
        detected: The decidable attacks that are detected.
        victim: The decidable attacks in which a victim is named.
        another: The decidable attacks in which a vehicle is named that is none.
        wrongly: The attacked instants in which a vehicle that is no victim is named anywhere.
    """

    attacker: str
    vehicles: int
    points: float | None
    covered: Share
    decidable: Share
    end_to_end: Share
    detected: Share
    victim: Share
    another: Share
    wrongly: Share


@dataclass(frozen=True)
class CleanRow:
    """Judged places without an attack.

    Args:
        vehicles: Number of vehicles.
        threshold: The threshold of other places, log-likelihood ratio.
        regions: The decidable regions that exceed it.
        instants: The instants in which one does.
        named: The instants in which a vehicle is named.
    """

    vehicles: int
    threshold: float
    regions: Share
    instants: Share
    named: Share


@dataclass(frozen=True)
class ConnectedAttackers:
    """All of them.

    Args:
        places: Number of judged places, and of others for thresholds.
        seed: Seed of the places.
        clean: A row for each number of vehicles.
        rows: A row for each attacker and number of vehicles.
    """

    places: int
    seed: int
    clean: Sequence[CleanRow]
    rows: Sequence[AttackerRow]


@dataclass(frozen=True)
class _Attack:
    """One ghost, as it is decided.

    Args:
        place: Name of the place.
        points: Points that were placed.
        score: Score of the best decidable region about it; -inf where there is none.
        covered: Whether a region is about it.
        decidable: Whether some such region is decidable.
        named: The vehicle that is named in that region, or below 0.
        victims: All victims of the instant.
        accused: All vehicles that are named at the instant.
    """

    place: str
    points: int
    score: float
    covered: bool
    decidable: bool
    named: int
    victims: frozenset[int]
    accused: frozenset[int]


def connected_attackers(
    places: int, seed: int = SEED, *, on_progress: Progress = no_progress
) -> ConnectedAttackers:
    """Attack all places in all ways.

    Args:
        places: Number of places that are judged, and of others that give thresholds.
        seed: Seed of the places, and of the attacks.
        on_progress: Function that gets the number of places that are done, and of all.
    """
    validator = ConnectedValidator(shipped_constants())
    thresholds = _thresholds(validator, places, seed, on_progress)
    clean: dict[int, list[tuple[str, ConnectedResult]]] = {each: [] for each in VEHICLES}
    attacks: dict[tuple[str, int], list[_Attack]] = {
        (attacker, vehicles): [] for attacker in ATTACKERS for vehicles in VEHICLES
    }

    def both(done: int, of: int) -> None:
        on_progress(done + places, 2 * places)

    for number, place in enumerate(usual_places(JUDGED, places, seed, both)):
        for vehicles in VEHICLES:
            instant = place.instant(usual(vehicles))
            clean[vehicles].append((instant.id, validator.validate(instant.scans)))
            for name, attacker in ATTACKERS.items():
                attacked = attacker(instant, (seed, number))
                attacks[name, vehicles] += _decided(instant.id, attacked, validator)
    return ConnectedAttackers(
        places,
        seed,
        [_clean_row(vehicles, thresholds[vehicles], clean[vehicles]) for vehicles in VEHICLES],
        [
            _row(name, vehicles, thresholds[vehicles], attacks[name, vehicles])
            for name in ATTACKERS
            for vehicles in VEHICLES
        ],
    )


def _thresholds(
    validator: ConnectedValidator, places: int, seed: int, on_progress: Progress
) -> dict[int, float]:
    """The thresholds of attack-free places of the training assets, by number of vehicles."""
    scores: dict[int, list[Floats]] = {vehicles: [] for vehicles in VEHICLES}

    def half(done: int, of: int) -> None:
        on_progress(done, 2 * of)

    part: Part = FITTED
    for place in usual_places(part, places, seed, half):
        for vehicles in VEHICLES:
            result = validator.validate(place.instant(usual(vehicles)).scans)
            scores[vehicles].append(result.score[result.decidable])
    return {
        vehicles: threshold_at(np.concatenate(found), RATE) for vehicles, found in scores.items()
    }


def _decided(
    place: str, attacked: Sequence[AttackedInstant], validator: ConnectedValidator
) -> Iterator[_Attack]:
    """What is decided of each ghost of an instant."""
    if not attacked:
        return
    result = validator.validate(attacked[-1].instant.scans)
    victims = frozenset(each.victim for each in attacked)
    for each in attacked:
        about = each.regions(result.regions)
        decided = np.flatnonzero(about & result.decidable)
        best = int(decided[result.score[decided].argmax()]) if len(decided) else None
        yield _Attack(
            place,
            each.points,
            -np.inf if best is None else float(result.score[best]),
            bool(about.any()),
            best is not None,
            -1 if best is None else int(result.named[best]),
            victims,
            frozenset(result.accused),
        )


def _row(name: str, vehicles: int, threshold: float, attacks: Sequence[_Attack]) -> AttackerRow:
    decided = [each for each in attacks if each.decidable]

    def share(cases: Sequence[_Attack], hit: Callable[[_Attack], bool]) -> Share:
        return share_of([hit(each) for each in cases], [each.place for each in cases])

    def detected(each: _Attack) -> bool:
        return each.score > threshold

    # Of two ghosts at an instant one stands for it.
    instants = list({each.place: each for each in attacks}.values())
    return AttackerRow(
        name,
        vehicles,
        float(np.median([each.points for each in attacks])) if attacks else None,
        share(attacks, lambda each: each.covered),
        share(attacks, lambda each: each.decidable),
        share(attacks, detected),
        share(decided, detected),
        share(decided, lambda each: each.named in each.victims),
        share(decided, lambda each: each.named >= 0 and each.named not in each.victims),
        share(instants, lambda each: bool(each.accused - each.victims)),
    )


def _clean_row(
    vehicles: int, threshold: float, clean: Sequence[tuple[str, ConnectedResult]]
) -> CleanRow:
    scores = [(place, result.score[result.decidable]) for place, result in clean]
    places = [place for place, _ in clean]
    return CleanRow(
        vehicles,
        threshold,
        share_of(
            np.concatenate([each > threshold for _, each in scores]),
            [place for place, each in scores for _ in each],
        ),
        share_of([bool((each > threshold).any()) for _, each in scores], places),
        share_of([bool(result.accused) for _, result in clean], places),
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--limit", type=int, default=60, help="places")
    parser.add_argument("--seed", type=int, default=SEED, help="of places and attacks")
    parser.add_argument("--json", type=Path, help="result file; default: standard output")
    options = parser.parse_args(arguments)

    def run(given: argparse.Namespace) -> ConnectedAttackers:
        with progress("attacking") as shown:
            return connected_attackers(given.limit, given.seed, on_progress=shown)

    return answer(options, run)


if __name__ == "__main__":
    sys.exit(main())
