"""`ConnectedValidator`: several vehicles and a base station at one instant, whole (chapter 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.base_station import SurfaceComparison
from avsec_gym.validation.connected.budget import MessageBudget
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.learned.exchange import decide_by_learning, exchange_both
from avsec_gym.validation.connected.learned.learned_fit import LearnedRule
from avsec_gym.validation.connected.merged_proposals import merge_proposals
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.ray_exchange import (
    RegionVelocities,
    decide_by_rays,
    exchange_rays,
    is_decidable,
)
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.surface_exchange import decide_by_surfaces, exchange_surfaces
from avsec_gym.validation.connected.surfaces.delaunay import delaunay_mesh
from avsec_gym.validation.connected.surfaces.mesh import Mesher
from avsec_gym.validation.connected.traffic import SentMessages, Wire, sound_wire
from avsec_gym.validation.connected.vehicle import RegionProposer
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

Method = Literal["rays", "surfaces", "learned"]


@dataclass(frozen=True, eq=False)
class ConnectedValidator:
    """Which of several vehicles is lied to by its LiDAR, if one is.

    Each vehicle proposes regions; the base station merges them and sends the set to all. By
    ``surfaces`` (the thesis, sections 4.4.1 to 4.4.4) vehicles send their mirrored crops, whose
    surfaces the base station compares. By ``rays`` they send where their rays ended, and the
    others answer whether their own rays ended there too or passed through.  By ``learned`` they do
    both, and a small model weighs what rays and surfaces state (section 6.2).

    Args:
        constants: What evidence is worth; see `ConnectedFit.constants`.
        method: ``rays``, ``surfaces`` or ``learned``.
        proposer: The function that proposes regions of a scan, all around.
        budget: The budget of what a vehicle sends by the method of rays.
        mesher: The mesher, which makes surfaces.
        learned: The model of ``learned`` and its threshold; see `LearnedFit.rule`.

    Raises:
        ConfigurationError: There is no such method, or ``learned`` comes without a model.

    Example:
        >>> scan = VehicleScan(np.zeros((0, 4), np.float32), np.eye(4))
        >>> ConnectedValidator().validate([scan, scan]).alarm
        False
    """

    constants: ConnectedConstants = field(default_factory=ConnectedConstants)
    method: Method = "rays"
    proposer: RegionProposer = field(default_factory=ClusterProposer)
    budget: MessageBudget = field(default_factory=MessageBudget)
    mesher: Mesher = delaunay_mesh
    learned: LearnedRule | None = None

    def __post_init__(self) -> None:
        if self.method not in get_args(Method):
            raise ConfigurationError(
                f"methods are 'rays', 'surfaces' and 'learned', got {self.method!r}"
            )
        if self.method == "learned" and self.learned is None:
            raise ConfigurationError(
                "the method 'learned' needs a model: learned=read_learned_fit(SHIPPED_MODEL).rule()"
            )

    def validate(
        self,
        scans: Sequence[VehicleScan],
        *,
        id: str = "",
        wire: Wire = sound_wire,
        motions: Sequence[RegionVelocities] | None = None,
    ) -> ConnectedResult:
        """Judge an instant.

        Args:
            scans: The scan of each vehicle, by number, two or more.
            id: Name of the instant.
            wire: What arrives of each message: a way to lose them, and to lie.
            motions: What each vehicle knows of what moves, by number; None: all stands.

        Raises:
            DataError: Fewer than two vehicles.
        """
        if len(scans) < 2:
            raise DataError(f"Connected vehicles are two or more, got {len(scans)}.")
        if self.method == "rays":
            return self._by_rays(scans, id, wire, motions)
        if self.learned is not None and self.method == "learned":
            return self._by_learning(scans, id, wire, motions, self.learned)
        return self._by_surfaces(scans, id, wire)

    def _by_rays(
        self,
        scans: Sequence[VehicleScan],
        id: str,
        wire: Wire,
        motions: Sequence[RegionVelocities] | None,
    ) -> ConnectedResult:
        constants, budget = self.constants, self.budget
        traffic = SentMessages(len(scans), wire, budget.nbytes)
        merged = merge_proposals(scans, self.proposer, traffic, budget)
        heard = exchange_rays(scans, merged, constants.margins, traffic, budget, motions)
        with traffic.step("decide"):
            decision = decide_by_rays(heard, merged, constants)
        return ConnectedResult(
            id,
            "rays",
            merged.regions,
            decision.score,
            decision.probability,
            is_decidable(heard.counts, constants.rates),
            decision.ghost,
            decision.removal,
            decision.named,
            traffic,
            counts=heard.counts,
            claims=heard.claims,
        )

    def _by_learning(
        self,
        scans: Sequence[VehicleScan],
        id: str,
        wire: Wire,
        motions: Sequence[RegionVelocities] | None,
        rule: LearnedRule,
    ) -> ConnectedResult:
        constants = self.constants
        heard = exchange_both(
            scans, constants, self.proposer, self.mesher, self.budget, wire, motions
        )
        testimonies, evidence, traffic = heard.testimonies, heard.evidence, heard.traffic
        with traffic.step("decide"):
            decision = decide_by_learning(testimonies, evidence, heard.merged, constants, rule)
        return ConnectedResult(
            id,
            "learned",
            evidence.regions,
            decision.score,
            decision.probability,
            evidence.compared(constants.rates),
            decision.ghost,
            decision.removal,
            decision.named,
            traffic,
            counts=testimonies.counts,
            distances=evidence.distances,
            claims=testimonies.claims,
        )

    def _by_surfaces(self, scans: Sequence[VehicleScan], id: str, wire: Wire) -> ConnectedResult:
        traffic = SentMessages(len(scans), wire)
        merged = merge_proposals(scans, self.proposer, traffic, None)
        comparison = SurfaceComparison(self.mesher, self.constants.epsilon)
        compared = exchange_surfaces(scans, merged, comparison, traffic)
        with traffic.step("decide"):
            decision = decide_by_surfaces(compared, merged, self.constants)
        return ConnectedResult(
            id,
            "surfaces",
            merged.regions,
            decision.score,
            decision.probability,
            np.asarray(np.isfinite(compared.distances).any(axis=(1, 2))),
            decision.ghost,
            decision.removal,
            decision.named,
            traffic,
            distances=compared.distances,
        )
