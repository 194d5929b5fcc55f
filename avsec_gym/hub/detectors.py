"""Weights of a detector, or of another network, as a folder of the hub."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.hub.readme import Readme, facts_table, hub_license
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import card_path, read_weights, write_card
from avsec_gym.perception.weights.tensor_files import read_tensors
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_fields import read_fields
from avsec_gym.storage.regular_files import is_there, read_bytes
from avsec_gym.storage.text_files import write_text

MODEL, CONFIG, README = "model.safetensors", "config.json", "README.md"
"""Model and config and readme as the hub names them; the configuration is the card of the
weights."""
MAX_BYTES = 4 * 2**30
LIMITS = (
    "Research on attacked perception. Small networks, trained briefly: they show how attacks act, "
    "and drive no car. Metrics are those on "
    "the frames that its scores were calibrated by, or else on its training's validation frames."
)
"""What the weights that come with the package are for, and what not."""
_AGAIN = "Fetch the whole repository again."
_TASKS = {"psmnet": "depth-estimation", "motion": "image-classification",
          "road_type": "image-classification"}  # fmt: skip


def export_weights(path: Path, out: Path, license: str | None = None) -> tuple[Path, ...]:
    """Write weights in the hub's layout.

    Args:
        path: A file of weights with its card beside it.
        out: The folder to write, new or empty of these files.
        license: The hub's name of their licence; needed where the card states none.

    Returns:
        The files.

    Raises:
        ConfigurationError: No licence is known.
        DataError: The weights are missing, damaged, without a card or not those of it; or a file
            of the export is there.
    """
    _, card = read_weights(path)
    if card is None:
        raise DataError(
            "These weights have no card, so that what they are is not known.",
            path=card_path(path),
            remedy="`avsec train` and `avsec weights import` write one.",
        )
    name = hub_license(license, card.license)
    write_bytes(out / MODEL, read_bytes(path, most=MAX_BYTES))
    write_text(out / CONFIG, json.dumps(asdict(card), indent=1) + "\n")
    write_text(out / README, _readme(path.stem, card, name).text())
    return tuple(out / file for file in (MODEL, CONFIG, README))


def import_weights(folder: Path, out: Path) -> ModelCard:
    """Weights from a folder of the hub's layout, as every detector takes them by ``weights=``.

    Nothing in it is executed: it holds tensors, names and numbers.

    Args:
        folder: A folder that `export_weights` wrote, such as a download of one.
        out: The file to write, such as ``mine.safetensors``; its card comes beside it.

    Returns:
        What is known of them.

    Raises:
        DataError: A file is missing, damaged or of other weights, or there already.
    """
    card = read_fields(ModelCard, folder / CONFIG, remedy=_AGAIN)
    _, content = read_tensors(folder / MODEL, remedy=_AGAIN)
    if card.sha256 != hashlib.sha256(content).hexdigest():
        raise DataError("The file is not the one of its card.", path=folder / MODEL, remedy=_AGAIN)
    if is_there(card_path(out)):
        raise DataError(
            "This exists already.",
            path=card_path(out),
            remedy="Name another file: nothing is replaced.",
        )
    write_bytes(out, content)
    return write_card(out, card)


def _readme(name: str, card: ModelCard, license: str) -> Readme:
    what: dict[str, Any] = {
        key: value
        for key, value in asdict(card).items()
        if key not in ("configuration", "data", "training", "metrics", "before", "beside")
    }
    detector = json.dumps({"name": card.network, "weights": "mine.safetensors"})
    use = (
        "```\navsec hub import DOWNLOAD --out mine.safetensors\n"
        f"avsec detect --detector '{detector}' ...\n```"
    )
    task = _TASKS.get(card.network, "object-detection")
    return Readme(
        name=name,
        summary=f"Weights of {card.network} for avsec-gym.",
        license=license,
        tags=("autonomous-driving", "adversarial-robustness", task, card.network),
        task=task,
        dataset="validation frames of the training",
        metrics=card.metrics,
        sections={
            "Use": use if task == "object-detection" else "",
            "Training": facts_table(what | {"training": card.training}),
            "Data": f"```json\n{json.dumps(card.data, indent=1)}\n```" if card.data else "",
            "Configuration": f"```json\n{json.dumps(card.configuration, indent=1)}\n```",
            "Intended use and limits": LIMITS,
        },
    )
