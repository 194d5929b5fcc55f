"""Several vehicles attacked at one instant: each by its own attack, or all by one ghost.

For users of the library: docs/connected.md states what such attacks reach.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avsec_gym.attacks.attack import Seed
from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.attacks.attacked_instant import (
    AttackedInstant,
    InstantAttack,
    with_scan,
)
from avsec_gym.validation.connected.recordings import RecordedInstant


def attack_several(
    instant: RecordedInstant, attacks: Sequence[InstantAttack], seed: Seed = 0
) -> list[AttackedInstant]:
    """Attack several vehicles, one after the other.

    Args:
        instant: What all vehicles scanned.
        attacks: The attacks, such as of different vehicles.
        seed: The seed that all of them share.

    Returns:
        Each attack that found something to attack; the instant of the last one has them all.
    """
    done: list[AttackedInstant] = []
    for attack in attacks:
        attacked = attack.attack(instant, seed)
        if attacked is not None:
            done.append(attacked)
            instant = attacked.instant
    return done


def with_the_same_ghost(attacked: AttackedInstant, vehicle: int) -> AttackedInstant:
    """The ghost of one victim in another vehicle's scan, too, at the same place in the world.

    The second victim's LiDAR gets the same points: those sides of the thing that face the first
    one, though the second one looks from elsewhere.

    Args:
        attacked: The instant with a ghost, whose points stand last in the first victim's scan.
        vehicle: Number of the second victim.

    Raises:
        ConfigurationError: The attack is no ghost, or there is no such other vehicle.
    """
    scans, first = attacked.instant.scans, attacked.victim
    if attacked.kind != "ghost" or vehicle == first or not 0 <= vehicle < len(scans):
        raise ConfigurationError(
            f"the ghost of vehicle {first} goes to another vehicle, from 0 to {len(scans) - 1};"
            f" got {vehicle} of a {attacked.kind}"
        )
    giver, taker = scans[first], scans[vehicle]
    ghost = giver.compensated().points[-attacked.points :]
    between = np.linalg.inv(attacked.instant.true_pose(vehicle)) @ attacked.instant.true_pose(first)
    own = ghost[:, :3].astype(np.float64) @ between[:3, :3].T + between[:3, 3]
    bogus = np.c_[taker.sweep.rolled(own), ghost[:, 3]].astype(np.float32)
    points = np.concatenate([taker.points, bogus])
    return AttackedInstant(
        with_scan(attacked.instant, vehicle, points),
        vehicle,
        "ghost",
        attacked.box,
        attacked.points,
    )
