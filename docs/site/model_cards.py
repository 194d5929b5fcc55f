"""Cards of what was learned and comes with the package: networks, patches, agents."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from contents import toctree
from repository import ROOT, address
from written_pages import write_changed

from avsec_gym.hub.agents import LIMITS as AGENT_LIMITS
from avsec_gym.hub.detectors import LIMITS as NETWORK_LIMITS

PACKAGE = ROOT / "avsec_gym"
WEIGHTS = PACKAGE / "perception/weights"
LICENCE = WEIGHTS / "LICENSE.md"
PATCH_LIMITS = (
    "Research on attacked perception: a printed pattern, trained against the small networks named "
    "above, in procedural images. Nothing is claimed of other networks, or of cameras on roads."
)


def write_pages(source: Path) -> set[Path]:
    """Write a page for each card, and their list; returns the files."""
    cards = {
        "Networks": [*sorted(WEIGHTS.glob("*.json"))],
        "Attacks": [*sorted((PACKAGE / "attacks/patches").glob("*.json"))],
        "Agents": [*sorted((PACKAGE / "agents/shipped").glob("*/card.json"))],
    }
    pages = {"Networks": network_page, "Attacks": patch_page, "Agents": agent_page}
    written, index = set(), "# Cards\n\nWhat was learned and comes with the package.\n"
    for group, files in cards.items():
        index += f"\n## {group}\n\n" + toctree(map(name_of, files), hidden=False)
        for file in files:
            text = pages[group](json.loads(file.read_text(encoding="utf-8")), file)
            written.add(write_changed(source / f"cards/{name_of(file)}.md", text.encode()))
    index += f"\nTheir licence: [LICENSE.md]({address(LICENCE)}).\n"
    return written | {write_changed(source / "cards/index.md", index.encode())}


def name_of(card: Path) -> str:
    """A page's name: ``dsgn_small``, ``patch_joint``, ``agent_ghost_place``."""
    if card.name == "card.json":
        return f"agent_{card.parent.name}"
    return f"patch_{card.stem}" if card.parent.name == "patches" else card.stem


def network_page(card: dict[str, Any], file: Path) -> str:
    """The page of a network's weights."""
    trainings = [*card["before"], card | {"seed": card["training"].get("seed")}]
    rows = {
        "network": f"`{card['network']}`, {card['parameters']:,} parameters",
        "data": _data(card["data"]),
        "trainings": f"{len(trainings)}, one after the other" if trainings[1:] else "one",
        "seed": _each(trainings, "seed"),
        "epochs": _each(trainings, "epochs"),
        "steps": _each(trainings, "steps"),
        "minutes": _each(trainings, "minutes"),
        "hardware of the last": card["hardware"],
        "arithmetic": _arithmetic(card),
        "stored as": card["storage"],
        "licence": card["license"],
        "made by": ", ".join(f"{name} {version}" for name, version in card["versions"].items()),
        "SHA-256": f"`{card['sha256']}`",
    }
    commands = "\n".join(training["command"] for training in trainings)
    return (
        f"# {file.stem}\n\n{_table(rows)}\n## Precision\n\n"
        f"{_table({_words(name): _figure(value) for name, value in card['metrics'].items()})}\n"
        f"## Commands\n\n```\n{commands}\n```\n\n{_limits(NETWORK_LIMITS, file)}"
    )


def patch_page(card: dict[str, Any], file: Path) -> str:
    """The page of a trained patch."""
    rows = {
        "trained against": "; ".join(_trained_against(*each) for each in card["detectors"].items()),
        "data": _one_set(card["data"]),
        "seed": card["training"]["seed"],
        "epochs": card["epochs"],
        "steps": card["steps"],
        "minutes": card["minutes"],
        "radius": f"{card['training']['radius']:g} pixels",
        "licence": "MIT",
        "made by": ", ".join(f"{name} {version}" for name, version in card["versions"].items()),
        "SHA-256": f"`{card['sha256']}`",
    }
    losses = {
        f"{detector}, {_words(what)}": _figure(value)
        for what, by in card["losses"].items()
        for detector, value in by.items()
    }
    return (
        f"# Patch: {file.stem}\n\n{_table(rows)}\n## Loss that it was trained on\n\n"
        f"Lower is better for the attacker; a grey patch is the control.\n\n"
        f"{_table(losses)}\n{_limits(PATCH_LIMITS, file)}"
    )


def agent_page(card: dict[str, Any], file: Path) -> str:
    """The page of a trained agent."""
    held_out = card["held_out"]
    low, high = held_out["success_interval"]
    rows = {
        "environment": f"[`{card['env']}`](../envs/{card['env'].partition('/')[2]}.md)",
        "arguments": f"`{json.dumps(card['env_kwargs'])}`",
        "algorithm": card["algorithm"],
        "seed": card["seed"],
        "steps": f"{card['steps']:,}",
        "seconds": _figure(card["seconds"]),
        "parameters": f"{card['parameters']:,}",
        "held-out episodes": f"{held_out['episodes']}, `{json.dumps(card['eval_env_kwargs'])}`",
        "success rate there": f"{held_out['success_rate']:.3f} (95 %: {low:.3f} to {high:.3f})",
        "licence": "MIT",
        "made by": ", ".join(f"{name} {version}" for name, version in card["versions"].items()),
        "SHA-256": f"`{card['sha256']}`",
    }
    return (
        f"# Agent: {file.parent.name}\n\n{_table(rows)}\n"
        f"## Command\n\n```\n{card['command']}\n```\n\n{_limits(AGENT_LIMITS, file)}"
    )


def _trained_against(detector: str, sha256: str) -> str:
    """A detector with the weights that it had, and whether the package's are others by now."""
    shipped = json.loads((WEIGHTS / f"{detector}_small.json").read_text(encoding="utf-8"))["sha256"]
    today = "the package's" if sha256 == shipped else f"the package's today are `{shipped[:12]}`"
    return f"{detector}, weights `{sha256[:12]}` ({today})"


def _data(data: dict[str, Any]) -> str:
    """Sets for training, validation and calibration, of detectors or of classifiers."""
    if "sources" in data:
        sets = ", ".join(map(_one_set, data["sources"]))
        split = ", ".join(
            f"{part}: {data[part]['frames']} frames" for part in ("training", "validation")
        )
        return f"{sets}; {split}"
    return "; ".join(f"{part}: {', '.join(map(_one_set, sets))}" for part, sets in data.items())


def _arithmetic(card: dict[str, Any]) -> str:
    """As recorded; trainings of 0.1.0 recorded what was allowed."""
    if card.get("arithmetic"):
        return str(card["arithmetic"])
    if card["training"].get("mixed_precision"):
        return "bfloat16 if the processor multiplies it, else float32; which is not recorded"
    return "float32"


def _one_set(data: dict[str, Any]) -> str:
    settings = data.get("settings", {})
    facts = [f"{data['frames']} frames"] if "frames" in data else []
    facts += [f"suite {settings['suite']}, seed {settings['seed']}"] if "suite" in settings else []
    return f"{data['name']} ({', '.join(facts)})"


def _each(trainings: list[dict[str, Any]], name: str) -> str:
    """A fact of each training, in their order."""
    return ", then ".join(_figure(training.get(name)) for training in trainings)


def _figure(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return "unknown" if value is None else str(value)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _table(rows: dict[str, Any]) -> str:
    return "| | |\n|---|---|\n" + "".join(f"| {name} | {value} |\n" for name, value in rows.items())


def _limits(limits: str, file: Path) -> str:
    recorded = f"All that is recorded: [{file.name}]({address(file)})."
    return f"## Intended use and limits\n\n{limits}\n\n{recorded}\n"
