"""The instants of connected vehicles that validators and spoofers are shown."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from avsec_gym.argument_checks import shown, whole_number
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.regular_files import is_folder
from avsec_gym.suggestions import unknown_name
from avsec_gym.unknown_source import unknown_source
from avsec_gym.validation.connected.recordings import RecordedInstant, recorded_instants
from avsec_gym.world.export import ConnectedWorld

SUITE = "connected"
"""The default suite, made in the cache on first use."""
_ARGUMENTS = ("source", "first", "count")
_KEPT = 8
_OF_A_CAR = (
    *("detector", "classifier", "selector", "planner", "clean"),
    *("response", "motion", "score_threshold", "road"),
)
REFUSED = {
    **dict.fromkeys(_OF_A_CAR, "no car drives at an instant of connected vehicles"),
    "attack": "an attack on one of several scans is a choice of the environment or its agent",
}
"""Parts of a car that have no meaning here, with the reason."""


@dataclass(frozen=True)
class NamedInstants:
    """Which instants are played: checked when it is named, read when it is played.

    Args:
        what: ``connected``, the folder of a data set, or a dictionary of ``source``, ``first`` and
            ``count``.

    Raises:
        ConfigurationError: The arguments name no instants.
        DataError: There is no such folder, or it holds something else.
    """

    what: Any
    source: str | Path = field(init=False)
    first: int = field(init=False)
    count: int | None = field(init=False)

    def __post_init__(self) -> None:
        given = self.what if isinstance(self.what, Mapping) else {"source": self.what}
        for name in given:
            if name not in _ARGUMENTS:
                problem = f"instants are named by source, first and count, not by {shown(name)}"
                raise ConfigurationError(unknown_name(problem, str(name), _ARGUMENTS))
        count, source = given.get("count"), given.get("source", SUITE)
        object.__setattr__(self, "first", whole_number("first", given.get("first", 0), 0))
        count = None if count is None else whole_number("count", count, 1)
        object.__setattr__(self, "count", count)
        if not isinstance(source, str | Path):
            raise ConfigurationError(
                f"scenarios are {SUITE!r} or a folder of `avsec world make --suite connected`, got"
                f" {shown(source)}"
            )
        if source != SUITE:
            if not is_folder(source):
                remedy = f"Name a folder of `avsec world make --suite connected`, or {SUITE!r}."
                raise unknown_source(str(source), [SUITE], remedy)
            ConnectedWorld(source).check_complete()  # Also refuses a folder of another layout.
        object.__setattr__(self, "source", source)


def vehicles_of(named: NamedInstants) -> int:
    """Number of vehicles, without rendering anything: the default suite has three."""
    return 3 if named.source == SUITE else len(ConnectedWorld(named.source).vehicles)


class PlayedInstants:
    """Instants by number or name; the last few stay in memory.

    Args:
        named: The data, by name or folder.

    Raises:
        ConfigurationError: None is left from `first` on.
        DataError: The vehicles are fewer than two.
    """

    def __init__(self, named: NamedInstants) -> None:
        source = named.source
        if source == SUITE:
            from avsec_gym.world.export import default_suite

            source = default_suite(SUITE)
        self.world = ConnectedWorld(source)
        every = self.world.ids()
        self.ids = every[named.first :][: named.count]
        if not self.ids:
            raise ConfigurationError(
                f"of {len(every)} instants, none is left from {named.first} on"
            )
        if len(self.world.vehicles) < 2:
            raise DataError("Connected vehicles are two or more.", path=source)
        self._kept: OrderedDict[str, RecordedInstant] = OrderedDict()

    def named(self, id: Any) -> str:
        """The id that a user picks at a reset.

        Raises:
            ConfigurationError: There is no such instant.
        """
        if str(id) not in self.ids:
            raise ConfigurationError(f"there is no instant {id!r}; the first is {self.ids[0]!r}")
        return str(id)

    def instant(self, id: str) -> RecordedInstant:
        """What all vehicles scanned, with the poses that they measured."""
        if id not in self._kept:
            [self._kept[id]] = recorded_instants(self.world, "measured", [id])
            if len(self._kept) > _KEPT:
                self._kept.popitem(last=False)
        return self._kept[id]


def without_an_episode(id: str, intention: str, *, over: bool) -> dict[str, Any]:
    """What every environment's info has, where no car drives.

    Args:
        id: Name of the instant.
        intention: A driving intention, which every environment accepts; it has no meaning here.
        over: Whether a step was taken.
    """
    # Not nan, which Gymnasium's checker takes for another value every time.
    return {
        "planned": False,
        "success": False,
        "collision": False,
        "safe": False,
        **dict.fromkeys(("cost", "path_length", "smallest_distance", "cost_sm1"), 0.0),
        "outcome": "unplanned" if over else "reset",
        "scenario": id,
        "intention": intention,
    }
