"""A vehicle keeps all that it sends of an instant within a few kilobytes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.messages.region_message import REGION_BYTES, RegionMessage
from avsec_gym.validation.connected.rays.claim_message import encode_claims
from avsec_gym.validation.connected.rays.claims import Claims
from avsec_gym.validation.connected.rays.witness_counts import WitnessCounts, most_rows


@dataclass(frozen=True)
class MessageBudget:
    """The bytes of a vehicle and instant, and what they are spent on.

    Args:
        nbytes: All that a vehicle sends.
        proposals: Share for its proposals.
        counts: Share for its counts of rays on the claims of all others together; claims have what
            is left.

    Raises:
        ConfigurationError: Fewer than 256 bytes, or shares that leave nothing for claims.
    """

    nbytes: int = 4096
    proposals: float = 0.25
    counts: float = 0.25

    def __post_init__(self) -> None:
        shares = self.proposals > 0 and self.counts > 0 and self.proposals + self.counts < 1
        if self.nbytes < 256 or not shares:
            raise ConfigurationError(
                "a budget has 256 bytes or more, and shares for proposals and counts that leave"
                f" some for claims; got {self}"
            )

    def proposals_within(self, message: RegionMessage) -> RegionMessage:
        """A vehicle's proposals, the surest of them if there are too many."""
        fixed = message.nbytes - REGION_BYTES * len(message.regions)
        most = int(self.nbytes * self.proposals - fixed) // REGION_BYTES
        return RegionMessage(message.sender, message.pose, message.regions[: max(most, 0)])

    def message_of_claims(self, claims: Claims, spent: int) -> bytes:
        """The message of a vehicle's claims: every second, third, ... voxel if they are too many.

        Args:
            claims: All that the vehicle could claim.
            spent: Bytes that its proposals took.
        """
        most = int(self.nbytes * (1 - self.counts)) - spent
        for step in range(1, _THINNEST + 1):
            thinned = _every(claims, step)
            if len(message := encode_claims(thinned)) <= most:
                return message
        # Too many regions: those with the most voxels are claimed.
        for kept in range(len(claims) - 1, 0, -1):
            chosen = np.sort(np.argsort(-claims.count, kind="stable")[:kept])
            if len(message := encode_claims(thinned[chosen])) <= most:
                return message
        return encode_claims(claims[np.zeros(0, np.int64)])

    def counts_within(self, counts: WitnessCounts, others: int) -> WitnessCounts:
        """The counts to send on another vehicle's claims: contradictions first, then most rays.

        Args:
            counts: All that it has counted.
            others: Number of the others, among which its share is divided.
        """
        share = int(self.nbytes * self.counts) // max(others, 1)
        with_rays = counts.counts.any(axis=1)
        counts = WitnessCounts(counts.region[with_rays], counts.counts[with_rays])
        order = np.lexsort((-counts.counts.sum(axis=1), -counts.counts[:, 1]))
        kept = np.sort(order[: most_rows(share)])
        return WitnessCounts(counts.region[kept], counts.counts[kept])


_THINNEST = 12
"""The thinnest share: of a claim of 120 voxels ten are left, twice as many as decide something."""


def _every(claims: Claims, step: int) -> Claims:
    """Of each claim every so manieth voxel, the first among them."""
    if step == 1:
        return claims
    first = np.cumsum(claims.count) - claims.count
    place = np.arange(len(claims.voxel)) - np.repeat(first, claims.count)
    return Claims(
        claims.region,
        claims.velocity,
        -(-claims.count // step),
        claims.voxel[place % step == 0],
        claims.time,
    )
