"""`avsec hub`: agents and weights in the layout of the Hugging Face hub."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from avsec_gym import console
from avsec_gym.errors import DataError
from avsec_gym.storage.regular_files import is_file, is_there
from avsec_gym.unknown_source import unknown_source


@dataclass(frozen=True)
class HubExport:
    """Write an agent or weights as a folder that can be uploaded to the hub as it is.

    Nothing is sent anywhere: `hf upload USER/NAME OUT` is yours, and so is a look at
    README.md, which states the command and the paths of the training.
    """

    model: Annotated[str, tyro.conf.Positional]
    """An agent's folder, a file of weights (.safetensors), or the name of a shipped one, such as
    ghost_place or dsgn_small."""
    out: Path
    """Folder for model.safetensors, config.yml or config.json, and README.md."""
    license: str | None = None
    """Licence in the hub's spelling, such as mit.  Default: the recorded one; there has to be
    one."""
    json: bool = False
    """Print the files as JSON."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.hub.agents import export_agent
        from avsec_gym.hub.detectors import export_weights

        weights = _weights(self.model)
        if weights is None and not is_there(self.model):
            _check_name(self.model)
        if weights is None:
            files = export_agent(self.model, self.out, self.license)
        else:
            files = export_weights(weights, self.out, self.license)
        if self.json:
            document = {"out": str(self.out), "files": [path.name for path in files]}
            console.print_json("hub.export", document)
        else:
            console.say(f"{self.out}: {', '.join(path.name for path in files)}")
        return console.DONE


@dataclass(frozen=True)
class HubImport:
    """Take an agent or weights from a folder in the hub's layout, such as a download of one.

    Nothing of it is executed.
    """

    folder: Annotated[Path, tyro.conf.Positional]
    """The folder: model.safetensors with config.yml and card.json, or with config.json."""
    out: Path
    """An agent's new folder, or the file of weights to write, such as mine.safetensors."""
    json: bool = False
    """Print what is known of it as JSON."""

    def run(self) -> int:
        """Do it; the exit code."""
        from dataclasses import asdict

        from avsec_gym.agents.agent_folder import CONFIG as OF_AGENTS
        from avsec_gym.hub.agents import import_agent
        from avsec_gym.hub.detectors import CONFIG as OF_WEIGHTS
        from avsec_gym.hub.detectors import import_weights

        if not is_there(self.folder):
            raise DataError("There is no such folder.", path=self.folder, remedy="Check the path.")
        if is_file(self.folder / OF_AGENTS):
            card = asdict(import_agent(self.folder, self.out))
        elif is_file(self.folder / OF_WEIGHTS):
            card = asdict(import_weights(self.folder, self.out))
        else:
            raise DataError(
                "There is neither config.yml nor config.json here.",
                path=self.folder,
                remedy="Name a folder that `avsec hub export` wrote, or a whole download of one.",
            )
        if self.json:
            console.print_json("hub.import", {"out": str(self.out), **card})
        else:
            console.say(f"{self.out}: {card.get('env') or card['network']}")
        return console.DONE


def _check_name(model: str) -> None:
    """Refuse what is neither a place that is there nor the name of a shipped agent.

    Raises:
        ConfigurationError: It is the name of a shipped agent or of weights, mistyped.
        DataError: There is no such file or folder.
    """
    from avsec_gym.agents.agent_folder import shipped_agents
    from avsec_gym.perception.weights.given import names_of_shipped_weights

    agents = shipped_agents()
    if model not in agents:
        raise unknown_source(
            model,
            [*agents, *names_of_shipped_weights()],
            "Name a folder of an agent, a file of weights (.safetensors), or what is shipped.",
            "agent and no file of weights named",
        )


def _weights(model: str) -> Path | None:
    """The file of weights that a name means; None where it is an agent's."""
    from avsec_gym.perception.weights.given import shipped_weights

    if model.endswith(".safetensors"):
        return Path(model)
    try:
        return shipped_weights(model)
    except DataError:
        return None
