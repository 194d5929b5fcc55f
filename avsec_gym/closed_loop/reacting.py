"""Which vehicles of a scene react: all that drive in a lane, a share of them, or named ones."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number, one_of, shown, whole_number
from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import unknown_name

RECORDED, REACTING = "recorded", "reacting"
"""What actors do: play their tracks, or, where they drive in a lane, drive by highway-env's IDM."""


@dataclass(frozen=True)
class Reacting:
    """The choice of vehicles that react, among those that drive in a lane at the start.

    Args:
        share: Share of them, from 0 to 1; which ones follows from the scene's id, and those of a
            smaller share are among those of a larger one.
        ids: Ids of actors instead; an id that a scene does not have, or that does not drive in a
            lane there, changes nothing in it.
    """

    share: float = 0.0
    ids: tuple[int, ...] | None = None

    @property
    def is_recorded(self) -> bool:
        """Whether every actor plays its track, in every scene."""
        return not (self.share if self.ids is None else self.ids)

    def chosen(self, scene: str, drivers: NDArray[np.int64]) -> frozenset[int]:
        """The ids of those that react.

        Args:
            scene: The scene's id.
            drivers: Ids of the vehicles that drive in a lane, shape (N,).
        """
        if self.ids is not None:
            return frozenset(drivers.tolist()) & frozenset(self.ids)
        order = np.random.default_rng(zlib.crc32(scene.encode())).permutation(len(drivers))
        return frozenset(drivers[order[: round(self.share * len(drivers))]].tolist())


def reacting_of(traffic: Any) -> Reacting:
    """The choice that an environment's ``traffic`` stands for.

    Args:
        traffic: ``"recorded"``; ``"reacting"``: all; ``{"reacting": 0.5}``: a share;
            ``{"reacting": [3, 7]}``: actors by their ids; or a `Reacting`.

    Raises:
        ConfigurationError: It is none of them.

    Example:
        >>> reacting_of({"reacting": [7, 3]})
        Reacting(share=0.0, ids=(3, 7))
    """
    if isinstance(traffic, Reacting):
        return traffic
    if not isinstance(traffic, Mapping):
        named = one_of("traffic", traffic, (RECORDED, REACTING))
        return Reacting(share=float(named == REACTING))
    for name in traffic:
        if name != REACTING:
            problem = f"traffic has no {name!r}"
            raise ConfigurationError(unknown_name(problem, str(name), [REACTING]))
    which = traffic.get(REACTING)
    if isinstance(which, Sequence) and not isinstance(which, str | bytes):
        ids = {whole_number("an actor's id in traffic", each, 0) for each in which}
        return Reacting(ids=tuple(sorted(ids)))
    if which is None or isinstance(which, str | bytes):
        raise ConfigurationError(
            'traffic as a dictionary is {"reacting": 0.5}, a share of the vehicles, or {"reacting":'
            f" [3, 7]}}, actors by their ids; got {shown(traffic)}"
        )
    return Reacting(share=number("the share that reacts in traffic", which, 0.0, 1.0))
