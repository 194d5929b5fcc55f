"""Models that are made a few times and then shared."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Protocol

import numpy as np

from avsec_gym.world.assets import Assets, draw_variant
from avsec_gym.world.mesh import Mesh

Make = Callable[[np.random.Generator], Mesh]
"""Makes one piece from a source of chance: the origin at its foot, its front facing -x."""


class Model(Protocol):
    """A piece of furniture in one or more variants."""

    __name__: str

    def __call__(self, rng: np.random.Generator, part: Assets = Assets.ALL) -> Mesh:
        """One of the variants that belong to a part of the assets."""


def prescribed(make: Make) -> Model:
    """A model that standards prescribe, the same in all parts of the assets: signs, lights."""

    @functools.wraps(make)
    def pick(rng: np.random.Generator, part: Assets = Assets.ALL) -> Mesh:
        return make(rng)

    return pick


def variants(count: int) -> Callable[[Make], Model]:
    """Make a model in `count` variants, each on first use; later calls pick one of them.

    A scene has dozens of the same lamp: sharing them costs microseconds instead of milliseconds.
    """

    def decorate(make: Make) -> Model:
        @functools.cache
        def variant(index: int) -> Mesh:
            return make(np.random.default_rng(index))

        @functools.wraps(make)
        def pick(rng: np.random.Generator, part: Assets = Assets.ALL) -> Mesh:
            return variant(draw_variant(rng, f"furniture/{make.__name__}", count, part))

        return pick

    return decorate
