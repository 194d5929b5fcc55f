"""Which assets a place is made of: a training part and a judging part that share nothing.

A detector that was trained on the very cars, houses and trees on which it is judged has learned an
asset shop.  So every kind of asset is split, by one rule:

- **Assets that are counted** (texture ``brick/2``, body design ``compact``, house ``terrace/11``,
  tree ``lime/3``, manner of a place ``city/5``) are ranked, within their family, by the SHA-256 of
  ``FAMILY/NAME``.  The first third of this order, at least one, judges; the others train.
- **Assets that are drawn from a seed** (the jitter of a body, clothes, lorries, courses, fences)
  belong to the part of their seed: a third of all seeds judges, by the SHA-256 of ``seed/NUMBER``.

The part of what is made follows from its seed alone: a place or an actor whose seed judges draws
all its counted assets from the judging part, textures included.  So a data set of one part takes
seeds of that part (`seed_of`), and nothing else has to be said anywhere.

What laws or standards prescribe is the same in both parts, as it is in the world: `SHARED`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from enum import StrEnum
from functools import lru_cache

import numpy as np

_ONE_IN = 3
"""Every so manieth asset judges."""


class Assets(StrEnum):
    """A part of the assets, or all of them."""

    TRAIN = "train"
    """What detectors are trained on: two thirds of each kind."""
    JUDGE = "judge"
    """What they are judged on: the other third."""
    ALL = "all"
    """Both: a third of the places and of the actors judges."""


SHARED = frozenset(
    {
        # Prescribed signs and posts, number plates.
        *("sign", "delineator", "traffic_cone", "warning_beacon", "plate"),
        # Belongs to the shape of a body design, which is split: seams, panes, doors.
        *("plain", "car_side", "side_glass", "windscreen", "rear_glass", "bonnet"),
        *("side_pane", "wind_pane", "rear_pane"),
        *("cargo_doors", "bus_door", "tarpaulin", "destination"),
    }
)
"""Families of textures and furniture that are the same in both parts; ``sign`` stands for all
``sign_...``."""


def part_of(seed: int) -> Assets:
    """The part that a seed belongs to: `Assets.TRAIN` or `Assets.JUDGE`."""
    return Assets.JUDGE if _number(f"seed/{seed}") % _ONE_IN == 0 else Assets.TRAIN


def seed_of(assets: Assets, seed: int) -> int:
    """The seed itself if it belongs to the part, else the next that does, in [0, 2**31).

    Args:
        assets: The part; every seed belongs to `Assets.ALL`.
        seed: Any seed in [0, 2**31).
    """
    while assets != Assets.ALL and part_of(seed) != assets:
        seed = (1103515245 * seed + 12345) % 2**31  # A generator of full period.
    return seed


@lru_cache(maxsize=4096)
def members(family: str, names: tuple[str, ...], part: Assets) -> tuple[str, ...]:
    """The names of a family that belong to a part, in their own order.

    Args:
        family: Name of the family, such as ``texture/brick``.
        names: All names of the family; with a single one both parts have it.
        part: The part; all names belong to `Assets.ALL`.
    """
    if part == Assets.ALL or len(names) < 2:
        return names
    ranked = sorted(names, key=lambda name: _number(f"{family}/{name}"))
    judging = set(ranked[: max(1, round(len(names) / _ONE_IN))])
    return tuple(name for name in names if (name in judging) == (part == Assets.JUDGE))


def variants(family: str, count: int, part: Assets) -> tuple[int, ...]:
    """`members` of a family whose names are the numbers from 0 to `count` - 1."""
    return tuple(int(name) for name in members(family, tuple(map(str, range(count))), part))


def draw_variant(rng: np.random.Generator, family: str, count: int, part: Assets) -> int:
    """One of the `variants`, each as likely."""
    choices: Sequence[int] = variants(family, count, part)
    return choices[int(rng.integers(len(choices)))]


def shared(family: str) -> bool:
    """Whether a family of textures or furniture is the same in both parts; see `SHARED`."""
    return family in SHARED or family.startswith("sign_")


@lru_cache(maxsize=65536)
def _number(name: str) -> int:
    """A stable number of a name, the same in every process and version."""
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:8])
