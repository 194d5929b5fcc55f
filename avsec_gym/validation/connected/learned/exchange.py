"""An instant by both methods, and what the learned comparison decides of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from avsec_gym.validation.connected.accusation import upheld_by_rays
from avsec_gym.validation.connected.base_station import SurfaceComparison
from avsec_gym.validation.connected.budget import MessageBudget
from avsec_gym.validation.connected.constants import ConnectedConstants
from avsec_gym.validation.connected.learned.features import RegionEvidence, region_features
from avsec_gym.validation.connected.learned.learned_fit import LearnedRule
from avsec_gym.validation.connected.merged_proposals import MergedProposals, merge_proposals
from avsec_gym.validation.connected.ray_exchange import (
    RegionVelocities,
    Testimonies,
    exchange_rays,
)
from avsec_gym.validation.connected.rays.decision import (
    CANNOT_TELL,
    NO_ATTACK,
    Decision,
    decide,
)
from avsec_gym.validation.connected.rays.fitting import ScoreProbability
from avsec_gym.validation.connected.surface_exchange import exchange_surfaces
from avsec_gym.validation.connected.surfaces.mesh import Mesher
from avsec_gym.validation.connected.traffic import SentMessages, Wire, sound_wire
from avsec_gym.validation.connected.vehicle import RegionProposer
from avsec_gym.validation.connected.vehicle_scan import VehicleScan

_ANY = 1e-12
"""Probability from which the rays name a vehicle where the model alarms."""


@dataclass(frozen=True, eq=False)
class HeardByBoth:
    """What the base station has heard of an instant by rays and by surfaces.

    Args:
        merged: The regions.
        testimonies: What was claimed and witnessed.
        evidence: What both methods state of the regions.
        traffic: All messages: those of rays within their budget, and the crops.
    """

    merged: MergedProposals
    testimonies: Testimonies
    evidence: RegionEvidence
    traffic: SentMessages


def exchange_both(
    scans: Sequence[VehicleScan],
    constants: ConnectedConstants,
    proposer: RegionProposer,
    mesher: Mesher,
    budget: MessageBudget,
    wire: Wire = sound_wire,
    motions: Sequence[RegionVelocities] | None = None,
) -> HeardByBoth:
    """Propose and merge once, then claims and testimonies, then crops and surfaces.

    Args:
        scans: The scan of each vehicle, by number.
        constants: What evidence is worth.
        proposer: The function that proposes regions of a scan, all around.
        mesher: The mesher, which makes surfaces.
        budget: What a vehicle sends beside its crops.
        wire: What arrives of each message.
        motions: What each vehicle knows of what moves; None: all stands.
    """
    traffic = SentMessages(len(scans), wire, budget.nbytes)
    merged = merge_proposals(scans, proposer, traffic, budget)
    heard = exchange_rays(scans, merged, constants.margins, traffic, budget, motions)
    # Crops are no part of that budget, which still holds for all else.
    of_crops = SentMessages(len(scans), wire)
    comparison = SurfaceComparison(mesher, constants.epsilon)
    compared = exchange_surfaces(scans, merged, comparison, of_crops)
    for sent, crops in zip(traffic.sent, of_crops.sent, strict=True):
        sent.update(crops)
    traffic.refused += of_crops.refused
    traffic.seconds |= of_crops.seconds
    evidence = RegionEvidence(merged.regions, heard.counts, compared.distances, merged.poses)
    return HeardByBoth(merged, heard, evidence, traffic)


def decide_by_learning(
    heard: Testimonies,
    evidence: RegionEvidence,
    merged: MergedProposals,
    constants: ConnectedConstants,
    rule: LearnedRule,
) -> Decision:
    """The model alarms; the rays name, by the rules that no single liar gets round.

    Args:
        heard: What was claimed and witnessed.
        evidence: What both methods state of the regions.
        merged: The regions.
        constants: What evidence of rays is worth.
        rule: The model and its threshold.

    Returns:
        Scores are log odds, -inf where nothing was compared.
    """
    rates = constants.rates
    compared = evidence.compared(rates)
    odds = rule.model.log_odds(region_features(evidence, rates, constants.rule))
    score = np.where(compared, odds, -np.inf)
    probability = np.where(compared, ScoreProbability().probability(odds), 0.0)
    # Whom the rays would name, had they alarmed.
    always = replace(constants.rule, alarm=_ANY)
    by_rays = decide(heard.counts, rates, always)
    named = upheld_by_rays(by_rays, heard.counts, heard.layers, merged.authors, rates, always)
    named = np.where(named == NO_ATTACK, CANNOT_TELL, named)
    named = np.where(score > rule.threshold, named, NO_ATTACK)
    return Decision(score, probability, by_rays.ghost, by_rays.removal, named)
