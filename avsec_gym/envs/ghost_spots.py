"""The spots that `avsec/GhostObject-v1` offers, and how often each of them is offered.

A spot counts where a ghost can close a gap between real objects.  Some close more gaps than others:
drawn evenly, a rule that knows the spots but not the objects would win often.  Each spot therefore
has a bias: the higher it is, the more rarely the spot is the place that makes the plan unsafe, and
the more often it is one of the others.  ``benchmarks/balance_ghost_spots.py`` finds the biases: it
lets such a rule learn from drawn places, changes the biases against it, and begins anew.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.storage.json_files import read_json_object

FEWEST = 24
"""A road type and intention with fewer spots of its own gets those of all."""


@dataclass(frozen=True, eq=False)
class Spots:
    """Where ghosts may stand, along the road.

    Args:
        positions: x ahead and y to the left, m, shape (S, 2).
        bias: The bias of each spot, see the module, shape (S,).
    """

    positions: Floats
    bias: Floats

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def poses(self) -> Floats:
        """x, y, heading 0, shape (S, 3)."""
        return np.column_stack([self.positions, np.zeros(len(self))])


def considered_spots() -> Floats:
    """All spots that are considered, x and y in m, shape (195, 2)."""
    x, y = np.meshgrid(np.arange(6.0, 21.0), np.arange(-6.0, 7.0), indexing="ij")
    return np.stack([x.ravel(), y.ravel()], axis=1)


@lru_cache(maxsize=8)
def spots_of(road_type: RoadType, intention: Intention) -> Spots:
    """The spots of a road type and an intention."""
    table = _table()
    rows = table[str(road_type)][str(intention)]
    if len(rows) < FEWEST:
        every = {(x, y) for kind in table.values() for own in kind.values() for x, y, _ in own}
        rows = [[x, y, 0.0] for x, y in sorted(every)]
    values = np.array(rows, float)
    return Spots(values[:, :2], values[:, 2])


def _table() -> dict[str, Any]:
    path = Path(__file__).with_name("ghost_spots.json")
    return dict(read_json_object(path, remedy="Install avsec-gym anew.")["spots"])
