"""`LyingVehicle`: one vehicle that makes up all of its messages, after it has heard the others'.

It is the rushing adversary of the literature on agreement: it hears everything that is sent, knows
the method, and speaks last. What is left to be searched is what it proposes and claims; whose
claims it denies follows from what the honest vehicles state of each other. `Colluders` are several
of them with one lie.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, wrap_angle
from avsec_gym.validation.connected.accusation import lone_authors
from avsec_gym.validation.connected.admission import admitted_proposals
from avsec_gym.validation.connected.base_station import complete_set_of_regions
from avsec_gym.validation.connected.merging import regions_in_world
from avsec_gym.validation.connected.messages.region_message import RegionMessage
from avsec_gym.validation.connected.rays.claim_message import decode_claims, encode_claims
from avsec_gym.validation.connected.rays.claims import (
    MARGIN,
    MOST_VOXELS_OF_ONE,
    Claims,
    grid_shapes,
)
from avsec_gym.validation.connected.rays.witness_counts import (
    WitnessCounts,
    decode_counts,
    encode_counts,
)
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import ConnectedResult
from avsec_gym.validation.connected.traffic import MessageKind

NUMBERS = 18
"""Numbers of a lie; see `lie_about`."""


@dataclass(frozen=True, eq=False)
class Lie:
    """What a vehicle makes up.

    Args:
        region: The region that it proposes, world frame, one.
        claimed: The part of the region in which it claims to see something: from and to, as shares
            of its length, width and height, shape (2, 3).
        velocity: How fast that moves along the world's x and y, m/s.
        shift: How far from the middle of the region it states to be, along the world's x and y,
            metres.
        denies: Whether it denies, too, what one honest vehicle's rays pass through of what another
            one claims, as if that were a ghost. Else it supports that, and what it claims itself
            lets the vehicle whose rays pass through seem to lack something.
        victim: The vehicle whose claims it denies whatever the others state; None: that of the
            honest ones which another one contradicts most.
    """

    region: Regions
    claimed: Floats
    velocity: tuple[float, float]
    shift: tuple[float, float]
    denies: bool = True
    victim: int | None = None


def lie_about(target: Regions, numbers: Floats) -> Lie:
    """The lie that a vector stands for, such as an optimiser draws.

    Args:
        target: A region of honest vehicles, world frame, one, which the lie bends.
        numbers: The choices from 0 to 1, shape (`NUMBERS`,): 3 that move the region by up to half
            of its size, 3 that halve or double its sizes, 1 that turns it by up to 90 degrees, each
            0.5 for the region itself; 6 for the part that is claimed, 2 for its velocity up to
            30 m/s, 2 for where the vehicle states to be, up to 40 m away, and 1 that denies above
            0.3.
    """
    numbers = np.clip(numbers, 0.0, 1.0)
    off = 2.0 * numbers - 1.0
    centre = target.centre + off[:3] * target.size / 2
    turned = wrap_angle(target.heading + off[6] * np.pi / 2)
    region = Regions(centre, target.size * 2.0 ** off[3:6], turned)
    (east, north), (right, ahead) = (30.0 * off[13:15]).tolist(), (40.0 * off[15:17]).tolist()
    claimed = np.sort(numbers[7:13].reshape(2, 3), axis=0)
    return Lie(region, claimed, (east, north), (right, ahead), bool(numbers[17] > 0.3))


class LyingVehicle:
    """A `Wire` on which one vehicle's messages are made up, and those of all others are heard.

    It hears what is sent before its own turn: give it the last number, and that is everything. Of
    the vehicle that another one contradicts most in its region it denies all claims, and supports
    those of all others.

    Args:
        number: Number of the vehicle that lies.
        lie: What it makes up.
    """

    def __init__(self, number: int, lie: Lie) -> None:
        self.number, self.lie = number, lie
        self._proposals: list[RegionMessage] = []
        self._claims: dict[int, Claims] = {}
        self._counts: dict[tuple[int, int], WitnessCounts] = {}

    def __call__(self, kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
        """What arrives of a message."""
        if sender == self.number:
            content = self._made_up(kind, content)
        if kind is MessageKind.PROPOSALS:
            heard = RegionMessage.from_bytes(content)
            self._proposals.append(RegionMessage(sender, heard.pose, heard.regions))
        elif kind is MessageKind.CLAIMS:
            self._claims[sender] = decode_claims(content, self._regions, at_intervals=True)
        elif kind is MessageKind.COUNTS:
            counts = decode_counts(content, self._regions)
            self._counts[self._asked_about(sender), sender] = counts
        return [content]

    @cached_property
    def index(self) -> int:
        """The region of the complete set that its own has become, or lies nearest to."""
        away = np.linalg.norm(self._regions.centre - self.lie.region.centre, axis=1)
        return int(away.argmin())

    @cached_property
    def is_lone_author(self) -> bool:
        """Whether it alone proposed that region."""
        taken = admitted_proposals(self._proposals)
        proposals = {each.sender: regions_in_world(each.regions, each.pose) for each in taken}
        region = self._regions[np.array([self.index])]
        return bool(lone_authors(region, proposals)[0] == self.number)

    def contradiction(self) -> float:
        """How strongly some honest vehicle contradicts another in that region.

        Rays that pass through, less twice those that support: of the pair with most.
        """
        rays = [_of_region(counts, self.index) for counts in self._honest().values()]
        return max((float(each[1] - 2 * each[0]) for each in rays), default=0.0)

    @cached_property
    def _regions(self) -> Regions:
        """The complete set as all vehicles read it, known once all have proposed."""
        complete = complete_set_of_regions(admitted_proposals(self._proposals))
        complete = RegionMessage.from_bytes(complete.to_bytes())
        return regions_in_world(complete.regions, complete.pose)

    def _honest(self) -> dict[tuple[int, int], WitnessCounts]:
        """What honest vehicles state of each other, by who claims and who bears witness."""
        return {pair: seen for pair, seen in self._counts.items() if self.number not in pair}

    def _asked_about(self, witness: int) -> int:
        """Whose claims a witness answers next: the base station asks by number."""
        answered = {about for about, by in self._counts if by == witness}
        return min(each for each in self._claims if each != witness and each not in answered)

    def _made_up(self, kind: MessageKind, content: bytes) -> bytes:
        if kind is MessageKind.PROPOSALS:
            return self._proposal()
        if kind is MessageKind.CLAIMS:
            return self._claim()
        return self._answer() if kind is MessageKind.COUNTS else content

    def _proposal(self) -> bytes:
        region, pose = self.lie.region, np.eye(4)
        pose[:3, 3] = region.centre[0] + [*self.lie.shift, _SENSOR_HEIGHT]
        own = Regions(region.centre - pose[:3, 3], region.size, region.heading)
        return RegionMessage(self.number, pose, own).to_bytes()

    def _claim(self) -> bytes:
        shape = grid_shapes(self._regions.grown(MARGIN, MARGIN).size[[self.index]])[0]
        along, across, up = (
            np.arange(min(int(low * cells), cells - 1), min(int(high * cells) + 1, cells))
            for (low, high), cells in zip(self.lie.claimed.T.tolist(), shape.tolist(), strict=True)
        )
        columns = along[:, None] * shape[1] + across
        voxel = (columns[..., None] * shape[2] + up).ravel()
        voxel = voxel[:: -(-len(voxel) // MOST_VOXELS_OF_ONE)]
        velocity, count = np.array([self.lie.velocity]), np.array([len(voxel)])
        return encode_claims(Claims(np.array([self.index]), velocity, count, voxel))

    def _answer(self) -> bytes:
        about, honest = self._asked_about(self.number), self._honest()
        through = {pair: _of_region(seen, self.index)[1] for pair, seen in honest.items()}
        victim = max(through, key=lambda pair: through[pair])[0] if through else about
        victim = victim if self.lie.victim is None else self.lie.victim
        claims = self._claims[about]
        counts = np.zeros((len(claims), 3), np.int64)
        counts[:, 1 if about == victim and self.lie.denies else 0] = claims.count
        # Of all regions there is no room; the one that matters comes first.
        kept = np.sort(np.argsort(claims.region != self.index, kind="stable")[:_ANSWERS])
        return encode_counts(WitnessCounts(claims.region[kept], counts[kept]))


class Colluders:
    """A `Wire` on which several vehicles tell one lie: they propose, claim, support and deny alike.

    Args:
        numbers: Numbers of the vehicles; those that speak last hear all others.
        lie: What they make up.

    Raises:
        ConfigurationError: No vehicle, or one of them is their victim.
    """

    def __init__(self, numbers: Sequence[int], lie: Lie) -> None:
        if not numbers or lie.victim in numbers:
            raise ConfigurationError(
                f"colluders are vehicles other than their victim {lie.victim}, got {numbers}"
            )
        self.liars = tuple(LyingVehicle(number, lie) for number in sorted(set(numbers)))

    def __call__(self, kind: MessageKind, sender: int, content: bytes) -> list[bytes]:
        """What arrives of a message."""
        # The sender's own lie first, which its accomplices then hear.
        for liar in sorted(self.liars, key=lambda each: each.number != sender):
            [content] = liar(kind, sender, content)
        return [content]

    @property
    def index(self) -> int:
        """The region of the complete set that is lied about."""
        return self.liars[0].index


_SENSOR_HEIGHT = 1.7
_ANSWERS = 40
"""Claims of each vehicle of which it states something."""


def _of_region(counts: WitnessCounts, index: int) -> NDArray[np.int64]:
    """The three counts of a region, shape (3,); 0 where nothing is reported."""
    return counts.counts[counts.region == index].sum(axis=0)


def nearest_to_conviction(result: ConnectedResult, liar: LyingVehicle) -> float:
    """How near a lie came to having an honest vehicle named, for an optimiser to climb.

    Args:
        result: What was decided.
        liar: The vehicle that lied.

    Returns:
        1 where an honest vehicle is named in the region that is lied about; else from -1 to 0, the
        nearer to 0 the more honest vehicles contradict each other there, which is what a liar can
        use; -2 where it alone proposed it, so that it counts for nothing.
    """
    if not len(result.regions) or liar.is_lone_author:
        return -2.0
    named = int(result.named[liar.index])
    if named >= 0 and named != liar.number:
        return 1.0
    return float(-1.0 / (1.0 + np.exp(liar.contradiction() / _TELLING)))


_TELLING = 10.0
"""Rays that pass through on which the measure of `nearest_to_conviction` turns."""
