"""The networks that an agent plays against, by the hashes of their weights.

What deceives a network, or what a driver can make of its answers, holds for its weights: an agent
that was trained against others is judged in another game.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from avsec_gym.attacks.attacked_detector import attack_kind
from avsec_gym.built_in_parts import METHODS
from avsec_gym.closed_loop.error_model.perception import ErrorModelPerception
from avsec_gym.closed_loop.perception import SensorPerception
from avsec_gym.envs.game_validator import is_measured
from avsec_gym.envs.identification_frames import has_scenes
from avsec_gym.envs.one_thread import one_thread
from avsec_gym.envs.sensor_identification import SensorIdentificationEnv
from avsec_gym.perception.weights.weights_hash import weights_hash
from avsec_gym.registry import Kind, make
from avsec_gym.validation.evidence.pair_depth import PairDepth

_LOG = logging.getLogger(__name__)
_REPORTED: set[str] = set()
_KINDS = (Kind.DETECTOR, Kind.ATTACK, Kind.CLASSIFIER, Kind.SELECTOR, Kind.VALIDATOR)
"""The parts of a car, and of an attack on it, that may have learned something."""


def environment_networks(environment: Any) -> dict[str, str]:
    """SHA-256 of the weights of each network in an environment; empty where there is none.

    Parts are made for it, as networks take seconds to load; no scene is read.  An error model
    stands for its detector, whose weights it names.

    Args:
        environment: An environment of this package, in wrappers or not.

    Returns:
        The hashes by part and network, such as ``detector stereo_rcnn``.

    Raises:
        DataError: A file of weights is missing or broken.

    Example:
        >>> from avsec_gym.agents.learner import single
        >>> environment_networks(single("avsec/GhostObject-v1", {}))
        {}
    """
    with one_thread():  # As wherever networks are made: a forked process could not go on.
        return {
            f"{role} {name}": weights
            for role, part in _parts_played_against(environment.unwrapped)
            for name, weights in _networks(part, set())
        }


def all_weights(
    before: Mapping[str, Sequence[str]], today: Mapping[str, str]
) -> dict[str, list[str]]:
    """The weights that an agent has been trained against, those of the last sitting at the end.

    Args:
        before: The weights of the sittings before, as an agent's card has them.
        today: The weights of this sitting, see `environment_networks`.
    """
    found = {name: [*weights] for name, weights in before.items()}
    for name, own in today.items():
        found[name] = [*(each for each in found.get(name, ()) if each != own), own]
    return found


def report_other_weights(
    agent: str, trained: Mapping[str, Sequence[str]], today: Mapping[str, str]
) -> None:
    """Log, once, that an agent was trained against other weights than it plays against now.

    Args:
        agent: The agent's name.
        trained: The weights that it was trained against; empty of a card that does not know.
        today: The weights of the environment that it plays in; a network that it was not trained
            against is another game by choice, and is not reported.
    """
    for name in today:
        others = [each for each in trained.get(name, ()) if each != today[name]]
        if not others:
            continue
        message = (
            f"the agent {agent} was trained against other weights of the {name}"
            f" ({', '.join(each[:8] for each in others)}) than it plays against now"
            f" ({today[name][:8]}): what it reaches here is no measure of an agent that was trained"
            " against these.  `avsec agents train` trains one."
        )
        if message not in _REPORTED:
            _REPORTED.add(message)
            _LOG.warning(message)


def _parts_played_against(environment: Any) -> Iterator[tuple[str, Any]]:
    """The parts with their roles; those that are never asked are left out."""
    # A driving car has its parts in its perception, if that senses anything.
    if hasattr(type(environment), "perception"):
        perception = environment.perception
        if isinstance(perception, SensorPerception):
            for kind in _KINDS:
                yield kind, getattr(perception.pipeline, kind)
        elif isinstance(perception, ErrorModelPerception):
            yield "error model of the detector", perception.model
        return
    if isinstance(environment, SensorIdentificationEnv):
        yield "depth", environment.depth
        if not has_scenes(environment.parts.scenarios, environment.parts.road):
            return  # No car drives in recordings.
    taken = {each.name for each in environment.taken_parts.parameters}
    for kind in _KINDS:
        what = getattr(environment.parts, kind) if kind in taken else None
        # A validator that is measured at the first reset matches by no network.
        if what is not None and not (kind == Kind.VALIDATOR and is_measured(what)):
            yield kind, make(attack_kind(what) if kind == Kind.ATTACK else kind, what)
    yield "surrogate", getattr(getattr(environment, "basis", None), "surrogate", None)


def _networks(part: Any, seen: set[int]) -> Iterator[tuple[str, str]]:
    """Name and weights of the networks of a part, and of what it is made of."""
    if id(part) in seen:
        return
    seen.add(id(part))
    if isinstance(part, PairDepth):
        if part.weights is not None:
            yield str(part.settings["name"]), part.weights
        return
    if (own := weights_hash(part)) is not None:
        yield str(getattr(part, "network_name", getattr(part, "name", type(part).__name__))), own
        return
    card = getattr(part, "card", None)
    if isinstance(card, Mapping) and isinstance(card.get("weights"), str):
        yield str(card.get("detector")), card["weights"]
    for inner in _made_of(part):
        yield from _networks(inner, seen)


def _made_of(part: Any) -> Iterable[Any]:
    """The parts within a part, such as the detector behind a defence."""
    for value in getattr(part, "__dict__", {}).values():
        for each in value if isinstance(value, tuple | list) else (value,):
            if isinstance(each, PairDepth) or any(hasattr(each, name) for name in _ABLE_TO):
                yield each


_ABLE_TO = frozenset(METHODS.values())
"""The methods of which every part has one."""
