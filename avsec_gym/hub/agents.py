"""A trained agent as a folder of the hub: the agent's own three files, and a card to read."""

from __future__ import annotations

import hashlib
from dataclasses import asdict
from pathlib import Path

from avsec_gym.agents.agent_folder import (
    CARD,
    CONFIG,
    WEIGHTS,
    AgentCard,
    agent_folder,
    load_agent,
    read_agent_card,
    read_configuration,
    shipped_agents,
)
from avsec_gym.errors import DataError
from avsec_gym.hub.readme import Readme, facts_table, hub_license
from avsec_gym.perception.weights.tensor_files import read_tensors
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.regular_files import is_file, read_bytes
from avsec_gym.storage.text_files import read_text, write_text

MODEL, README = "model.safetensors", "README.md"
"""Model and readme as the hub names them."""
MAX_BYTES = 2**30
LIMITS = (
    "Research on the driving safety of attacked cars, in simulation. One training with one seed: "
    "others differ by more than the interval. It knows the scenes of its training's distribution; "
    "nothing is claimed of real traffic."
)
"""What an agent is for, and what not."""
_NAMED_ALIKE = (CONFIG, CARD)
_TAGS = "reinforcement-learning", "stable-baselines3", "gymnasium", "autonomous-driving"
_AGAIN = "Fetch the whole repository again."
_SHIPPED_LICENSE = "MIT"


def export_agent(place: str | Path, out: Path, license: str | None = None) -> tuple[Path, ...]:
    """Write an agent in the hub's layout; it is loaded first, so that nothing broken gets out.

    Args:
        place: Folder of the agent, or the name of a shipped one.
        out: The folder to write, new or empty of these files.
        license: The hub's name of its licence; that of a shipped agent is known.

    Returns:
        The files.

    Raises:
        ConfigurationError: No licence is known.
        DataError: There is no such agent, it is damaged, or a file of the export is there.
    """
    folder = agent_folder(place)
    shipped = str(place) in shipped_agents() and not is_file(Path(place) / CARD)
    name = hub_license(license, _SHIPPED_LICENSE if shipped else None)
    load_agent(place)
    write_bytes(out / MODEL, read_bytes(folder / WEIGHTS, most=MAX_BYTES))
    for file in _NAMED_ALIKE:
        write_text(out / file, read_text(folder / file))
    write_text(out / README, _readme(Path(place).name, read_agent_card(folder), name).text())
    return tuple(out / file for file in (MODEL, *_NAMED_ALIKE, README))


def import_agent(folder: Path, out: Path) -> AgentCard:
    """An agent from a folder of the hub's layout, as `load_agent` takes it.

    Nothing in it is executed.  Its weights have to be those of its card, and its configuration one
    of an environment that is known here; that they fit is seen when it is loaded.

    Args:
        folder: A folder that `export_agent` wrote, such as a download of one.
        out: The folder to write.

    Returns:
        What is known of it.

    Raises:
        DataError: A file is missing, damaged or of another agent, or there in `out`.
    """
    _, content = read_tensors(folder / MODEL, remedy=_AGAIN)
    read_configuration(folder)
    card = read_agent_card(folder)
    if card.sha256 != hashlib.sha256(content).hexdigest():
        raise DataError("The file is not the one of its card.", path=folder / MODEL, remedy=_AGAIN)
    write_bytes(out / WEIGHTS, content)
    for file in _NAMED_ALIKE:
        write_text(out / file, read_text(folder / file))
    return card


def _readme(title: str, card: AgentCard, license: str) -> Readme:
    judged: dict[str, float] = {
        name: value for name, value in card.held_out.items() if name in ("success_rate", "reward")
    }
    low, high = card.held_out.get("success_interval", (None, None))
    interval = "" if low is None else f" (95 % interval {low:.3f} to {high:.3f})"
    environment = card.env
    use = (
        "```python\n"
        "from avsec_gym.agents.agent_folder import load_agent\n\n"
        'agent = load_agent("FOLDER")  # made by: avsec hub import DOWNLOAD --out FOLDER\n'
        "action, _ = agent.predict(observation)\n"
        "```"
    )
    return Readme(
        name=title,
        summary=f"An agent of stable-baselines3 ({card.algorithm}) in avsec-gym's `{environment}`.",
        license=license,
        tags=(*_TAGS, environment),
        task="reinforcement-learning",
        dataset=environment,
        metrics=judged,
        sections={
            "Use": use,
            "Held-out episodes": f"{card.held_out['episodes']} episodes in scenes that it has not "
            f"learned from: success rate {card.held_out['success_rate']:.3f}{interval}."
            if judged
            else "It has not been judged.",
            "Training": facts_table(
                {key: value for key, value in asdict(card).items() if key != "held_out"}
            ),
            "Intended use and limits": LIMITS,
        },
    )
