"""How often a vehicle that lies has an honest one named: searched at places without an attack.

Run ``python -m studies.chapter4.connected_liars --json FILE``.  The last vehicle of each place
makes up all that it sends, after it has heard the others.  By rays, its lie is about the region in
which honest vehicles contradict each other most, and CMA-ES bends it; by surfaces it sends what
another vehicle sees, which sides with that one in every region at once.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypedDict

import numpy as np

from avsec_gym.agents.extras import cma_module
from avsec_gym.console import progress
from avsec_gym.experiments.chapter4.procedural_instants import ScannedPlace
from avsec_gym.experiments.chapter4.settings import FIVE, JUDGED
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.progress import Progress, no_progress
from avsec_gym.storage.json_lines import JsonLines
from avsec_gym.validation.connected.attacks.lying_vehicle import (
    NUMBERS,
    LyingVehicle,
    lie_about,
    nearest_to_conviction,
)
from avsec_gym.validation.connected.base_station import SurfaceComparison
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.merged_proposals import merge_proposals
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.proposals.remembered import RememberedProposals
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.surface_exchange import (
    ComparedSurfaces,
    decide_by_surfaces,
    exchange_surfaces,
)
from avsec_gym.validation.connected.surfaces.delaunay import delaunay_mesh
from avsec_gym.validation.connected.traffic import SentMessages
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from studies.answer import answer
from studies.chapter4.usual_places import SEED, shipped_constants, usual, usual_places

VEHICLES = (3, FIVE.vehicles)
LIARS = {3: (0,), FIVE.vehicles: (0, 1)}
"""Numbers of liars that the rule reckons with, by number of vehicles: with one, three never name
anyone."""
TARGETS = 3
"""Regions that are lied about as they are, before the best of these lies is bent."""


@dataclass(frozen=True)
class LiarRow:
    """Instants of so many vehicles, of which one lies, under one rule.

    Args:
        method: ``rays`` or ``surfaces``.
        vehicles: Number of vehicles, the liar among them.
        liars: Number of liars that the rule reckons with; see `DecisionRule`.
        alone: The share of instants in which an honest vehicle is named while the liar is silent.
        convicted: The share in which one is named when it lies.
    """

    method: str
    vehicles: int
    liars: int
    alone: Share
    convicted: Share


@dataclass(frozen=True)
class ConnectedLiars:
    """All of them.

    Args:
        places: Number of places, each of which stands in every row once.
        seed: Seed of the places.
        evaluations: Lies that are tried at an instant, at most.
        contradicted: The share of instants, by number of vehicles, ``3`` and so on, in which rays
            of some honest vehicle pass through what another one claims, more than twice as many as
            support it.
        rows: A row for each method, number of vehicles and rule.
    """

    places: int
    seed: int
    evaluations: int
    contradicted: Mapping[str, Share]
    rows: Sequence[LiarRow]


class LiedAt(TypedDict):
    """A place in the file of what was tried."""

    id: str
    contradicted: dict[str, bool]
    named: list[list[Any]]


def connected_liars(
    places: int,
    seed: int = SEED,
    evaluations: int = 100,
    *,
    surfaces: bool = True,
    kept: JsonLines | None = None,
    on_progress: Progress = no_progress,
) -> ConnectedLiars:
    """Lie at all places.

    Args:
        places: Number of places.
        seed: Seed of the places.
        evaluations: Lies that are tried at an instant, at most.
        surfaces: Whether lies about surfaces are tried, too.
        kept: Where places are kept at which all was tried; None: in memory.
        on_progress: Function that gets the number of places that are done, and of all.
    """
    constants = shipped_constants()
    kept = JsonLines(None, LiedAt) if kept is None else kept
    done: list[dict[str, Any]] = []
    for number, place in enumerate(usual_places(JUDGED, places, seed, on_progress)):
        id = f"{seed} {number}, {evaluations} lies{', surfaces' * surfaces}"
        if id not in kept.rows:
            kept.add({"id": id, **_lied_at(place, constants, evaluations, surfaces)})
        done.append(kept.rows[id])
    clusters = [str(number) for number in range(places)]
    named: dict[tuple[str, int, int], list[tuple[bool, bool]]] = {}
    for row in done:
        for method, vehicles, liars, alone, convicted in row["named"]:
            named.setdefault((method, vehicles, liars), []).append((alone, convicted))
    return ConnectedLiars(
        places,
        seed,
        evaluations,
        {
            str(vehicles): share_of([row["contradicted"][str(vehicles)] for row in done], clusters)
            for vehicles in VEHICLES
        },
        [
            LiarRow(*case, *(share_of(flags, clusters) for flags in zip(*pairs, strict=True)))
            for case, pairs in sorted(named.items())
        ],
    )


def _lied_at(
    place: ScannedPlace, constants: ConnectedConstants, evaluations: int, surfaces: bool
) -> dict[str, Any]:
    """Whether honest vehicles contradict each other at a place, and who is named by which rule."""
    contradicted: dict[str, bool] = {}
    named: list[list[Any]] = []
    for vehicles in VEHICLES:
        honest = place.instant(usual(vehicles)).scans[:-1]
        validator = ConnectedValidator(constants, proposer=RememberedProposals())
        alone = validator.validate(honest)
        contradicted[str(vehicles)] = bool(contradictions(alone).max(initial=0.0) > 0)
        for liars in LIARS[vehicles]:
            own = with_liars(constants, liars)
            pair = by_rays(honest, alone, replace(validator, constants=own), evaluations)
            named.append(["rays", vehicles, liars, *pair])
            if surfaces:
                named.append(["surfaces", vehicles, liars, *by_surfaces(honest, own)])
    return {"contradicted": contradicted, "named": named}


def with_liars(constants: ConnectedConstants, liars: int) -> ConnectedConstants:
    """The same evidence, with a rule that reckons with so many liars."""
    return replace(constants, rule=replace(constants.rule, liars=liars))


def by_rays(
    honest: Sequence[VehicleScan],
    alone: ConnectedResult,
    validator: ConnectedValidator,
    evaluations: int,
) -> tuple[bool, bool]:
    """Whether an honest vehicle is named while one more is silent, and when that one lies.

    Args:
        honest: The scans of all others.
        alone: What these decide among themselves.
        validator: The validator, with its rule.
        evaluations: Lies that are tried, at most.
    """
    silent = VehicleScan(np.zeros((0, 4), np.float32), np.eye(4))
    scans = [*honest, silent]
    order = np.argsort(-contradictions(alone), kind="stable")[:TARGETS]
    targets = [alone.regions[np.array([index])] for index in order]

    def conviction(target: Regions, numbers: Floats) -> float:
        liar = LyingVehicle(len(honest), lie_about(target, numbers))
        result = validator.validate(scans, wire=liar)
        # A lie may have effects elsewhere, too.
        anywhere = any(vehicle != liar.number for vehicle in result.accused)
        return 1.0 if anywhere else nearest_to_conviction(result, liar)

    def searched() -> Iterator[float]:
        """How near each lie comes to a conviction."""
        plain = [(target, numbers) for target in targets for numbers in plain_lies()]
        scores = [conviction(*lie) for lie in plain]
        yield from scores
        if plain:
            target, numbers = plain[int(np.argmax(scores))]
            yield from _bent(lambda each: conviction(target, each), numbers, evaluations)

    # The first conviction ends the search.
    lied = any(score == 1.0 for score in searched())
    return bool(validator.validate(scans).accused), lied


def contradictions(alone: ConnectedResult) -> Floats:
    """How strongly some vehicle contradicts another in each region.

    Rays that pass through, less twice those that support: of the pair with most, shape (R,).
    """
    assert alone.counts is not None, "of rays"
    return (alone.counts[..., 1] - 2.0 * alone.counts[..., 0]).max(axis=(1, 2), initial=0.0)


def plain_lies() -> Iterator[Floats]:
    """Lies about a region as it is, claimed nearly whole, by a vehicle that stands aside.

    One denies what another vehicle's rays pass through; one supports it.
    """
    for denies in (1.0, 0.0):
        numbers = np.full(NUMBERS, 0.5)
        numbers[7:10], numbers[10:13], numbers[15:17], numbers[17] = 0.05, 0.95, 0.7, denies
        yield numbers


def _bent(
    conviction: Callable[[Floats], float], numbers: Floats, evaluations: int
) -> Iterator[float]:
    """How near each lie comes that CMA-ES makes of one."""
    options = {"bounds": [0, 1], "seed": 1, "verbose": -9, "maxfevals": evaluations}
    # The measure is flat where no honest vehicle contradicts another.
    options |= {"tolflatfitness": 10**6, "tolfun": 0, "tolfunhist": 0}
    search = cma_module().CMAEvolutionStrategy(numbers, 0.12, options)
    while not search.stop():
        drawn, scores = search.ask(), []
        for each in drawn:
            scores.append(conviction(np.asarray(each)))
            yield scores[-1]
        search.tell(drawn, [-score for score in scores])


def by_surfaces(honest: Sequence[VehicleScan], constants: ConnectedConstants) -> tuple[bool, bool]:
    """Whether an honest vehicle is named among the others, and when one more copies one of them.

    Args:
        honest: The scans of all others.
        constants: What evidence is worth, with its rule.
    """
    traffic = SentMessages(len(honest))
    merged = merge_proposals(honest, ClusterProposer(), traffic, None)
    comparison = SurfaceComparison(delaunay_mesh, constants.epsilon)
    compared = exchange_surfaces(honest, merged, comparison, traffic)
    alone = decide_by_surfaces(compared, merged, constants)
    # The liar proposes all regions, so that none has a lone author.
    proposed = {**merged.of_vehicles, len(honest): merged.regions}
    seconded = replace(merged, of_vehicles=proposed)
    lied = False
    for copied in range(len(honest)):
        named = decide_by_surfaces(with_a_copy(compared, copied), seconded, constants).named
        lied |= bool(((named >= 0) & (named != len(honest))).any())
    return bool((alone.named >= 0).any()), lied


def with_a_copy(compared: ComparedSurfaces, copied: int) -> ComparedSurfaces:
    """The comparison with one more vehicle, last, which sends the surfaces of another one.

    Args:
        compared: The comparison of n vehicles.
        copied: Number of the vehicle whose surfaces it sends.
    """
    distances, top = compared.distances, compared.top
    regions, vehicles = top.shape
    whole = np.full((regions, vehicles + 1, vehicles + 1), np.nan)
    whole[:, :-1, :-1] = distances
    whole[:, -1, :-1] = whole[:, :-1, -1] = distances[:, copied]
    # Of itself it is no distance away, where there is a surface.
    there = np.isfinite(top[:, copied])
    whole[there, -1, copied] = whole[there, copied, -1] = 0.0
    return ComparedSurfaces(whole, np.c_[top, top[:, copied]])


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--limit", type=int, default=100, help="places")
    parser.add_argument("--seed", type=int, default=SEED, help="of the places")
    parser.add_argument("--evaluations", type=int, default=100, help="lies tried at an instant")
    parser.add_argument("--samples", type=Path, help="what was tried at each place; goes on there")
    parser.add_argument("--json", type=Path, help="result file; default: standard output")
    options = parser.parse_args(arguments)

    def run(given: argparse.Namespace) -> ConnectedLiars:
        kept = JsonLines(given.samples, LiedAt)
        with progress("lying") as shown:
            return connected_liars(
                given.limit, given.seed, given.evaluations, kept=kept, on_progress=shown
            )

    return answer(options, run)


if __name__ == "__main__":
    sys.exit(main())
