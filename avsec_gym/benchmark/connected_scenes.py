"""The instants of connected vehicles of the benchmark's version, which stay the same.

Places of the procedural world, of judging assets, each with three vehicles that scan it once; their
poses and clocks err as usual in chapter 4.  Each place is judged as it is, with a ghost in one
vehicle's scan, and with an object removed from one.  A digest of all actors shows whether
the package still makes these places.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np

from avsec_gym.benchmark.scene_sets import refused, version_file
from avsec_gym.experiments.chapter4.procedural_instants import ScannedPlace
from avsec_gym.experiments.chapter4.settings import JUDGED, USUAL
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.world.drives import Instant

CONNECTED = "connected"
"""Name of the set."""


@dataclass(frozen=True)
class FrozenInstants:
    """Instants of connected vehicles.

    Args:
        seed: Seed of the places; nothing of the package was fitted on it.
        digests: What `digest_of_instant` made of each place when it was frozen, by its number.
        quick: The number of places of a quick entry, the first ones.
    """

    seed: int
    digests: Mapping[int, str]
    quick: int

    @property
    def digest(self) -> str:
        """Sixteen hexadecimal digits that stand for all places."""
        return hashlib.sha256(" ".join(self.digests.values()).encode()).hexdigest()[:16]

    def numbers(self, *, quick: bool = False) -> list[int]:
        """The numbers of the places of an entry, in order."""
        return [*self.digests][: self.quick if quick else None]

    def place(self, number: int) -> ScannedPlace:
        """A place, which is not scanned yet."""
        return ScannedPlace(self.seed, JUDGED, number, USUAL.vehicles)

    def instant(self, number: int) -> RecordedInstant:
        """What the vehicles scan at a place, without an attack.

        Raises:
            ConfigurationError: This release makes another place.
        """
        place = self.place(number)
        if digest_of_instant(place.posed.instant) != self.digests[number]:
            raise refused(CONNECTED)
        return place.instant(USUAL)


@cache
def frozen_instants() -> FrozenInstants:
    """The instants of this version."""
    found = version_file()[CONNECTED]
    digests = {int(number): digest for number, digest in found["digests"].items()}
    return FrozenInstants(found["seed"], digests, found["quick"])


def digest_of_instant(instant: Instant) -> str:
    """Sixteen hexadecimal digits that stand for all actors, to the millimetre."""
    digest = hashlib.sha256(" ".join(map(str, instant.egos)).encode())
    actors = instant.actors
    columns = np.column_stack([actors.dimensions, actors.pose, actors.z, actors.speed])
    for category, numbers in zip(actors.category.tolist(), columns.tolist(), strict=True):
        # Zero has one sign.
        places = " ".join(f"{round(number, 3) + 0.0:.3f}" for number in numbers)
        digest.update(f"{category} {places}\n".encode())
    return digest.hexdigest()[:16]
