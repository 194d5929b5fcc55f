"""An agent as a folder: weights (safetensors), configuration (YAML), card (JSON).

Nothing in it is executed when it is loaded: it holds tensors, names and numbers.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avsec_gym.agents.configuration import (
    AgentConfiguration,
    configuration_from,
    known_environment,
)
from avsec_gym.agents.yaml_files import read_yaml, write_yaml
from avsec_gym.argument_checks import one_of, whole_number
from avsec_gym.errors import AvsecError, ConfigurationError, DataError
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_fields import read_fields
from avsec_gym.storage.regular_files import is_file, is_folder
from avsec_gym.storage.text_files import write_text
from avsec_gym.unknown_source import unknown_source

if TYPE_CHECKING:
    from torch import nn

WEIGHTS, CONFIG, CARD = "weights.safetensors", "config.yml", "card.json"
SHIPPED = Path(__file__).parent / "shipped"
_LARGEST_SEED = 2**31 - 1
_AGAIN = "Train it again with `avsec agents train`."


@dataclass(frozen=True)
class AgentCard:
    """What is known of an agent.

    Args:
        env: The environment that it was trained in.
        env_kwargs: The arguments of that environment.
        eval_env_kwargs: What differs in the held-out environment.
        algorithm: How it learned.
        seed: The seed of the training.
        steps: Environment steps that it learned from.
        seconds: The time that took.
        finished: Whether it learned as long as it was asked to.
        parameters: How many numbers are learned.
        sha256: The SHA-256 of the weights' file.
        versions: The versions of what made it.
        command: The command that made it.
        held_out: Episodes, success rate and interval in held-out scenes; empty: not judged yet.
        networks: SHA-256 of the weights of each network that it was trained against, by part and
            network; several where they changed between two sittings.  Empty: there was none, or
            the card is of a version that did not record them.
    """

    env: str
    env_kwargs: dict[str, Any]
    eval_env_kwargs: dict[str, Any]
    algorithm: str
    seed: int
    steps: int
    seconds: float
    finished: bool
    parameters: int
    sha256: str
    versions: dict[str, str] = field(default_factory=dict)
    command: str = ""
    held_out: dict[str, Any] = field(default_factory=dict)
    networks: dict[str, list[str]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class TrainedAgent:
    """An agent with the interface of stable-baselines3.

    Args:
        name: The folder, or the name of a shipped one.
        configuration: How it was trained.
        card: What is known of it.
        policy: A policy of stable-baselines3.
    """

    name: str
    configuration: AgentConfiguration
    card: AgentCard
    policy: Any

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        """Actions for an observation or a batch, and the state."""
        actions, state = self.policy.predict(observation, state, episode_start, deterministic)
        return actions, state


def shipped_agents() -> list[str]:
    """The names of the agents that come with the package."""
    return sorted(path.parent.name for path in SHIPPED.glob(f"*/{CARD}"))


def load_agent(place: str | Path) -> TrainedAgent:
    """An agent from its folder.

    One that was trained against other weights of a network than its held-out environment has now
    is logged.

    Args:
        place: A folder, or the name of a shipped agent.

    Raises:
        DataError: There is no agent, or a file of it is missing, damaged or of another agent, or
            holds arguments that the environment refuses.
    """
    from avsec_gym.agents.environment_networks import environment_networks, report_other_weights
    from avsec_gym.agents.learner import make_policy, single
    from avsec_gym.perception.weights.state_dict import fit_state
    from avsec_gym.perception.weights.tensor_files import read_tensors

    folder = agent_folder(place)
    configuration, card = read_configuration(folder)[0], read_agent_card(folder)
    path = folder / WEIGHTS
    state, content = read_tensors(path, remedy=_AGAIN)
    if card.sha256 != hashlib.sha256(content).hexdigest():
        raise DataError("The file is not the one of its card.", path=path, remedy=_AGAIN)
    try:
        environment = single(configuration.env, configuration.held_out_kwargs)
        policy = make_policy(configuration, environment)
        # Networks are made for it: only if there is something to compare.
        today = environment_networks(environment) if card.networks else {}
        environment.close()
    except AvsecError as error:
        raise DataError(
            f"Its environment or its policy refuses what it holds: {error}.",
            path=folder / CONFIG,
            remedy=_AGAIN,
        ) from error
    policy.load_state_dict(fit_state(state, policy, path))
    report_other_weights(str(place), card.networks, today)
    return TrainedAgent(str(place), configuration, card, policy)


def save_agent(folder: Path, policy: nn.Module, card: AgentCard) -> AgentCard:
    """Write the weights, and the card with their size and hash; the configuration is there."""
    from safetensors.torch import save

    # Copies: networks that share a layer have it twice in a file.
    state = {name: value.detach().clone() for name, value in policy.state_dict().items()}
    content = save(state, metadata={"algorithm": card.algorithm})
    facts = asdict(card) | {
        "parameters": sum(value.numel() for value in policy.parameters()),
        "sha256": hashlib.sha256(content).hexdigest(),
    }
    write_bytes(folder / WEIGHTS, content, overwrite=True)
    return write_agent_card(folder, AgentCard(**facts))


def write_agent_card(folder: Path, card: AgentCard) -> AgentCard:
    """Write a card over the one that is there."""
    text = json.dumps(asdict(card), indent=1, allow_nan=False) + "\n"
    write_text(folder / CARD, text, overwrite=True)
    return card


def read_agent_card(folder: Path) -> AgentCard:
    """The card of an agent.

    Raises:
        DataError: It is missing or damaged.
    """
    return read_fields(AgentCard, folder / CARD, remedy=_AGAIN)


def write_configuration(folder: Path, configuration: AgentConfiguration, seed: int) -> None:
    """Write how an agent is trained."""
    facts = {
        "env": configuration.env,
        "algorithm": configuration.algorithm,
        "seed": seed,
        "hyperparameters": configuration.entry(),
    }
    write_yaml(folder / CONFIG, facts)


def read_configuration(folder: Path) -> tuple[AgentConfiguration, int]:
    """How an agent is trained, and its seed.

    Raises:
        DataError: The file is missing or damaged.
    """
    from avsec_gym.agents.algorithms import ALGORITHMS

    path = folder / CONFIG
    facts = read_yaml(path, remedy=_AGAIN)
    env, algorithm, seed = (facts.get(name) for name in ("env", "algorithm", "seed"))
    try:
        known = known_environment(str(env))
        algorithm = one_of("algorithm", algorithm, ALGORITHMS)
        seed = whole_number("seed", seed, 0, _LARGEST_SEED)
    except ConfigurationError as error:
        raise DataError(f"{error}.", path=path, remedy=_AGAIN) from error
    return configuration_from(known, algorithm, facts.get("hyperparameters"), path), seed


def agent_folder(place: str | Path) -> Path:
    """The folder of an agent; a folder of the user goes before a shipped one of the same name.

    Raises:
        ConfigurationError: It is the name of a shipped one, mistyped.
        DataError: There is none.
    """
    folder = Path(place)
    if is_file(folder / CARD):
        return folder
    if str(place) in shipped_agents():
        return SHIPPED / str(place)
    if is_folder(folder):
        raise DataError("There is no agent here: it lacks a card.", path=folder, remedy=_AGAIN)
    expected = "Name an agent's folder, or a shipped one: `avsec agents list` names them."
    raise unknown_source(str(place), shipped_agents(), expected, "agent")
