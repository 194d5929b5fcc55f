"""What can be decided at all: whose rays reach what another vehicle claims.

By geometry alone, of scans without an attack and from where the vehicles really are: the answer is
the same for all methods and all errors of poses, and is known before any of them is asked.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.attacks.chosen_places import EXACT_MARGINS, rays_at_ghost
from avsec_gym.validation.connected.rays.claims import MOST_VOXELS, MOST_VOXELS_OF_ONE, claim
from avsec_gym.validation.connected.rays.observer import observe
from avsec_gym.validation.connected.rays.witness_counts import count_rays
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.regions import Regions

LEAST_RAYS = 5
"""Rays that end at what is claimed or pass through it, none in front: fewer decide nothing."""
_AT_ONCE = MOST_VOXELS // MOST_VOXELS_OF_ONE
"""Regions that are claimed together, so few that none has fewer voxels because of the others."""


class CleanRays:
    """All vehicles' rays at an instant, from their true poses, before anything is attacked.

    Args:
        instant: What all vehicles scanned, attack-free.
    """

    def __init__(self, instant: RecordedInstant) -> None:
        self._observers = [
            observe(replace(scan, pose=instant.true_pose(number)))
            for number, scan in enumerate(instant.scans)
        ]

    def decidable(self, regions: Regions) -> NDArray[np.bool_]:
        """Whether some vehicle has rays at what another one claims in each region, shape (R,).

        Args:
            regions: R regions in the world.
        """
        found = np.zeros(len(regions), bool)
        for begin in range(0, len(regions), _AT_ONCE):
            some = regions[begin : begin + _AT_ONCE]
            for number, claimer in enumerate(self._observers):
                claims = claim(claimer, some)
                for other, witness in enumerate(self._observers):
                    if other != number:
                        seen = count_rays(witness, claims, some, EXACT_MARGINS).counts
                        enough = seen[:, :2].sum(axis=1) >= LEAST_RAYS
                        found[begin + claims.region[enough]] = True
        return found

    def witnesses(self, attacked: AttackedInstant) -> int:
        """The number of vehicles with which the victim's scan can be compared at an attack.

        Of a ghost, these are the others with rays at what the victim claims there; of a removal,
        those that claim something there at which the victim has rays.

        Args:
            attacked: An attack on this instant.
        """
        others = [
            observer for number, observer in enumerate(self._observers) if number != attacked.victim
        ]
        victim, box = self._observers[attacked.victim], attacked.box
        if attacked.kind == "ghost":
            scan = attacked.instant.scans[attacked.victim].compensated()
            ghost = scan.points[len(scan.points) - attacked.points :, :3].astype(np.float64)
            rays = rays_at_ghost(others, ghost, box, victim.pose, scan.time)
        else:
            seen = [count_rays(victim, claim(each, box), box, EXACT_MARGINS) for each in others]
            rays = np.array([int(each.counts[:, :2].sum()) for each in seen])
        return int((rays >= LEAST_RAYS).sum())
