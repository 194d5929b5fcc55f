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
        traffic: ``"recorded"``; ``"reacting"``: all; ``{"name": "reacting", "share": 0.5}``: a
            share; ``{"name": "reacting", "ids": [3, 7]}``: actors by their ids; or a `Reacting`.

    Raises:
        ConfigurationError: It is none of them.

    Example:
        >>> reacting_of({"name": "reacting", "ids": [7, 3]})
        Reacting(share=0.0, ids=(3, 7))
    """
    if isinstance(traffic, Reacting):
        return traffic
    arguments = dict(traffic) if isinstance(traffic, Mapping) else {"name": traffic}
    name = one_of("traffic", arguments.pop("name", None), (RECORDED, REACTING))
    known = ("share", "ids") if name == REACTING else ()
    for given in arguments:
        if given not in known:
            problem = f"the traffic {name!r} has no argument {given!r}"
            raise ConfigurationError(unknown_name(problem, str(given), known))
    if len(arguments) > 1:
        raise ConfigurationError("traffic reacts by a share or by ids: give one of them")
    if "ids" in arguments:
        return Reacting(ids=_ids(arguments["ids"]))
    share = arguments.get("share", float(name == REACTING))
    return Reacting(share=number("the share of traffic that reacts", share, 0.0, 1.0))


def _ids(given: Any) -> tuple[int, ...]:
    """Ids of actors, in order."""
    if isinstance(given, str | bytes) or not isinstance(given, Sequence):
        raise ConfigurationError(f"ids in traffic are a list such as [3, 7], got {shown(given)}")
    return tuple(sorted({whole_number("an actor's id in traffic", each, 0) for each in given}))
