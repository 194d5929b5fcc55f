"""Two independent vehicles accuse a third, or none is named: what a single liar cannot get round.

A vehicle that lies sides with whoever contradicts an honest one. Honest vehicles contradict each
other hardly ever in the box of an object, but often enough in boxes that were made for it: beside
an object, across its corner, at a wrong heading. Hence the *lone author* of a region, which alone
proposed it, is none of the two that accuse in it. As a third voice it counts: where two others
contradict the accused one at all, one of them and the author may be those that do so clearly.

A liar may also bend the box of an object by so little that it stays that of another vehicle, too.
There, honest vehicles contradict each other over roofs and edges alone, on which rays of one end
and above which those of the next pass: few cells, in one layer or two. Hence rays accuse only where
`CLEAR_RAYS` or more of them pass through, or find nothing where they would return, and more than
twice as many pass as support, what is claimed in `LAYERS` layers or more, as most of what stands on
the ground is. An optimiser found this (`LyingVehicle`). What is left are the clear contradictions
of honest vehicles in honest regions, at few instants: there a liar's voice and that of one honest
vehicle are two. `DecisionRule.liars` asks for as many accusers more.

Two that lie alike are two accusers. Hence those that side with the accused outweigh as many
accusers: the vehicles whose rays confirm what it claims or, if it seems to lack something, pass
through that, too.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import rectangle_overlap
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.merging import seen_from_above
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL, Decision, DecisionRule
from avsec_gym.validation.connected.rays.rates import RayRates, decidable, log_likelihood_ratio
from avsec_gym.validation.connected.regions import Regions

ACCUSERS = 2
"""Vehicles that accuse a third, more than side with it, beside those that may lie."""
CLEAR_RAYS = 8
"""Rays by which a vehicle accuses clearly, at least: chosen on places that are never judged, where
ten name fewer victims, and six have honest vehicles named more often."""
LAYERS = 3
"""Layers of voxels, one above the other, in which a claim lies by which a vehicle accuses or is
accused, at least."""
SAME_REGION = 0.4
"""Intersection over union of volumes from which a proposal is about the same object."""
NO_LONE_AUTHOR = -1


def lone_authors(
    regions: Regions, proposals: Mapping[int, Regions], same: float = SAME_REGION
) -> NDArray[np.int64]:
    """Which vehicle proposed each region alone.

    Args:
        regions: The complete set, world frame, R of them.
        proposals: What each vehicle proposed, by its number, world frame.
        same: Intersection over union of volumes from which a proposal is of the same region.

    Returns:
        Number of the vehicle, or `NO_LONE_AUTHOR`, shape (R,).
    """
    senders = np.array(sorted(proposals), np.int64)
    proposed = np.array(
        [(_volume_iou(regions, proposals[sender]) >= same).any(axis=1) for sender in senders], bool
    ).reshape(len(senders), len(regions))
    alone = proposed.sum(axis=0) == 1
    return np.where(alone, (proposed * senders[:, None]).sum(axis=0), NO_LONE_AUTHOR)


def upheld_by_rays(
    decision: Decision,
    counts: NDArray[np.int64],
    layers: NDArray[np.int64],
    authors: NDArray[np.int64],
    rates: RayRates,
    rule: DecisionRule,
) -> NDArray[np.int64]:
    """The victims that enough independent vehicles accuse by their rays, less those that side.

    Args:
        decision: What was decided of R regions.
        counts: What witness ``k`` reports of the claim of ``j``, shape (R, V, V, 3).
        layers: The number of layers of voxels in which each vehicle's claim lies, shape (R, V).
        authors: Lone author of each region, shape (R,).
        rates: The chances of rays.
        rule: The rule, with the ratio from which on a vehicle accuses.

    Returns:
        The victim, `CANNOT_TELL` or `NO_ATTACK`, shape (R,).
    """
    named = decision.named.copy()
    decided, ratio = decidable(counts, rates), log_likelihood_ratio(counts, rates)
    denies, confirms = decided & (ratio >= rule.accuser), decided & (ratio <= -rule.accuser)
    contradicts = denies.copy()
    support, through, missing = np.moveaxis(counts, -1, 0)
    contradicts &= (through > 2 * support) & (through + missing >= CLEAR_RAYS)
    contradicts &= (layers >= LAYERS)[:, :, None]
    for index in np.flatnonzero(named >= 0):
        victim = named[index]
        of_ghost = decision.ghost[index, victim] >= decision.removal[index, victim]
        # Witnesses of what it claims, or those whose claims its own rays deny.
        accuses = contradicts[index, victim] if of_ghost else contradicts[index, :, victim]
        # Witnesses that agree with it, or that deny as it does what its accusers claim.
        sides = confirms[index, victim] if of_ghost else denies[index, accuses].any(axis=0)
        # Two do so clearly, the author perhaps among them; without it, two at all, or more where
        # liars are reckoned with.
        at_all = denies[index, victim] if of_ghost else denies[index, :, victim]
        clearly = _independent(accuses, int(victim), NO_LONE_AUTHOR)
        independent = _independent(at_all, int(victim), int(authors[index]))
        siding = int(np.delete(sides, victim).sum())
        if clearly - siding < ACCUSERS or independent - siding < ACCUSERS + rule.liars:
            named[index] = CANNOT_TELL
    return named


def upheld_by_distances(
    named: frozenset[int],
    distances: Floats,
    threshold: float,
    author: int,
    needed: int = ACCUSERS,
) -> frozenset[int]:
    """The vehicles named in a region whose surface enough independent others contradict.

    Args:
        named: The vehicles that were named, see `attacked_vehicles`.
        distances: Distances of the surfaces of all pairs, metres, shape (n, n), NaN where nothing
            was compared.
        threshold: Theta, metres.
        author: Lone author of the region, or `NO_LONE_AUTHOR`.
        needed: How many they are.
    """
    contradicts = distances > threshold
    # What is accused together is one party: it gives no witness against its own members.
    party = np.isin(np.arange(len(distances)), list(named))
    return frozenset(
        vehicle
        for vehicle in named
        if _independent(contradicts[vehicle] & ~party, vehicle, author) >= needed
    )


def _independent(accuses: NDArray[np.bool_], victim: int, author: int) -> int:
    """How many vehicles accuse, without the lone author of the region."""
    numbers = np.arange(len(accuses))
    return int((accuses & (numbers != victim) & (numbers != author)).sum())


def _volume_iou(regions: Regions, others: Regions) -> Floats:
    """Intersection over union of the boxes of every pair, shape (N, M)."""
    bottom, top = regions.centre[:, 2], regions.centre[:, 2] + regions.size[:, 2]
    other_bottom, other_top = others.centre[:, 2], others.centre[:, 2] + others.size[:, 2]
    height = np.minimum(top[:, None], other_top) - np.maximum(bottom[:, None], other_bottom)
    common = rectangle_overlap(seen_from_above(regions), seen_from_above(others))
    common = common * np.maximum(height, 0.0)
    volumes = regions.size.prod(axis=1)[:, None] + others.size.prod(axis=1)
    return np.asarray(common / (volumes - common))
