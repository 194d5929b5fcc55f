"""All methods on the same regions of an instant, region by region."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter4.named_vehicles import NamedVehicles
from avsec_gym.experiments.chapter4.settings import Namer
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.base_station import SurfaceComparison
from avsec_gym.validation.connected.budget import MessageBudget
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.learned.exchange import decide_by_learning
from avsec_gym.validation.connected.learned.features import RegionEvidence
from avsec_gym.validation.connected.learned.learned_fit import LearnedRule
from avsec_gym.validation.connected.merged_proposals import merge_proposals
from avsec_gym.validation.connected.ray_exchange import (
    decide_by_rays,
    exchange_rays,
)
from avsec_gym.validation.connected.rays.decision import Decision
from avsec_gym.validation.connected.rays.rates import decidable
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import AttackKind
from avsec_gym.validation.connected.surface_exchange import (
    SurfaceDecision,
    decide_by_surfaces,
    exchange_surfaces,
)
from avsec_gym.validation.connected.traffic import MessageKind, SentMessages
from avsec_gym.validation.connected.validator import Method
from avsec_gym.validation.connected.vehicle import RegionProposer
from avsec_gym.validation.connected.vehicle_scan import VehicleScan


@dataclass(frozen=True, eq=False)
class MethodResult:
    """What a method makes of R regions of V vehicles.

    Args:
        score: How much speaks for an attack, shape (R,); -inf where nothing was compared.
        probability: The fitted probability of an attack, shape (R,); 0 where nothing was compared.
        seconds: CPU time of each step, of all vehicles together.
    """

    score: Floats
    probability: Floats
    seconds: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class ComparedInstant:
    """An instant by all methods.

    Args:
        regions: What the base station made of the proposals, R of them.
        deciding: Whether witness ``k`` has enough rays at what ``j`` claims in each region to
            decide, whatever they show, shape (R, V, V).
        distances: Distances of the surfaces of all pairs of vehicles, metres, shape (R, V, V), NaN
            where nothing was compared (equation 4.1).
        results: The results by method.
        named: The vehicles that are named, by method and by the thesis' own rule.
        sent: The bytes that each vehicle sent, by kind of message, shape (V,) each; see `SENT_BY`.
        from_station: The bytes that the base station sent to all, by kind of message.
    """

    regions: Regions
    deciding: NDArray[np.bool_]
    distances: Floats
    results: Mapping[Method, MethodResult]
    named: Mapping[Namer, NamedVehicles]
    sent: Mapping[MessageKind, NDArray[np.int64]]
    from_station: Mapping[str, int]

    @property
    def decidable(self) -> NDArray[np.bool_]:
        """Whether some vehicle decides about another one's claim in each region, shape (R,)."""
        return np.asarray(self.deciding.any(axis=(1, 2)))

    def witnesses(self, about: NDArray[np.bool_], victim: int, kind: AttackKind) -> int:
        """The number of vehicles whose rays, or whose claims, decide about an attack's victim.

        Args:
            about: Whether each region is about what was attacked, shape (R,).
            victim: The number of the attacked vehicle.
            kind: What was attacked: of a ghost all others bear witness of the victim's claim, of a
                removal the victim does of theirs.
        """
        pairs = self.deciding[about, victim] if kind == "ghost" else self.deciding[about, :, victim]
        return int(np.delete(pairs, victim, axis=1).sum(axis=1).max(initial=0))


def compared_instant(
    scans: Sequence[VehicleScan],
    constants: ConnectedConstants,
    proposer: RegionProposer,
    learned: LearnedRule,
) -> ComparedInstant:
    """Compare what vehicles scanned by surfaces, by rays, and by what was learned of both.

    All take the regions that are left within the budget of the method of rays.

    Args:
        scans: The scan of each vehicle, by number.
        constants: What evidence is worth.
        proposer: The function that proposes regions of a scan, all around.
        learned: The model of the learned comparison.
    """
    budget = MessageBudget()
    by_rays = _CpuTraffic(len(scans), most_bytes=budget.nbytes)
    merged = merge_proposals(scans, proposer, by_rays, budget)
    # Both begin with the same proposals, and pay for them.
    by_surfaces = _CpuTraffic(len(scans))
    by_surfaces.sent = [Counter(sent) for sent in by_rays.sent]
    by_surfaces.seconds = dict(by_rays.seconds)

    comparison = SurfaceComparison(epsilon=constants.epsilon)
    compared = exchange_surfaces(scans, merged, comparison, by_surfaces)
    with by_surfaces.step("decide"):
        of_surfaces = decide_by_surfaces(compared, merged, constants)

    heard = exchange_rays(scans, merged, constants.margins, by_rays, budget)
    with by_rays.step("decide"):
        of_rays = decide_by_rays(heard, merged, constants)

    # The learned comparison takes what both have sent, and what they took to send it.
    by_both = _CpuTraffic(len(scans))
    by_both.sent = [
        rays | surfaces for rays, surfaces in zip(by_rays.sent, by_surfaces.sent, strict=True)
    ]
    by_both.from_station = by_rays.from_station
    by_both.seconds = {**by_surfaces.seconds, **by_rays.seconds}
    del by_both.seconds["decide"]
    with by_both.step("decide"):
        evidence = RegionEvidence(merged.regions, heard.counts, compared.distances, merged.poses)
        of_both = decide_by_learning(heard, evidence, merged, constants, learned)

    results: dict[Method, MethodResult] = {
        "surfaces": _result(of_surfaces, by_surfaces),
        "rays": _result(of_rays, by_rays),
        "learned": _result(of_both, by_both),
    }
    count = len(scans)
    return ComparedInstant(
        merged.regions,
        decidable(heard.counts, constants.rates),
        compared.distances,
        results,
        {
            "thesis": NamedVehicles.of_thesis(compared.distances, constants.theta),
            "surfaces": NamedVehicles.of(of_surfaces.named, count),
            "rays": NamedVehicles.of(of_rays.named, count),
            "learned": NamedVehicles.of(of_both.named, count),
        },
        {kind: np.array([sent[kind] for sent in by_both.sent]) for kind in MessageKind},
        by_both.from_station,
    )


class _CpuTraffic(SentMessages):
    """Messages whose steps take CPU time, which a busy machine does not lengthen."""

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        begin = time.process_time()
        try:
            yield
        finally:
            passed = time.process_time() - begin
            self.seconds[name] = self.seconds.get(name, 0.0) + passed


def _result(decided: SurfaceDecision | Decision, traffic: SentMessages) -> MethodResult:
    return MethodResult(decided.score, decided.probability, traffic.seconds)
