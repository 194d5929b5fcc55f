"""The card of a model on the hub: a README with a header in YAML that the hub reads."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from avsec_gym.errors import ConfigurationError

_LICENSE = re.compile(r"[a-z0-9][a-z0-9.-]*")


@dataclass(frozen=True)
class Readme:
    """What the card of a model states.

    Args:
        name: The model's name.
        summary: One sentence on what the network or agent is.
        license: The hub's name of its licence, such as ``mit``.
        tags: Words that it is found by.
        task: The hub's name of what it does, such as ``object-detection``.
        dataset: The data that it was judged on.
        metrics: What came out there, by name.
        sections: The rest of the page: a text for each heading.
    """

    name: str
    summary: str
    license: str
    tags: Sequence[str]
    task: str
    dataset: str
    metrics: Mapping[str, float]
    sections: Mapping[str, str]

    def text(self) -> str:
        """The file: header, then Markdown."""
        values: dict[str, Any] = {
            "library_name": "avsec-gym",
            "license": self.license,
            "tags": list(self.tags),
            "pipeline_tag": self.task,
        }
        if self.metrics:
            results = {
                "task": {"type": self.task},
                "dataset": {"name": self.dataset, "type": re.sub(r"\W+", "-", self.dataset)},
                "metrics": [
                    {"type": name, "value": value, "name": name.replace("_", " ")}
                    for name, value in self.metrics.items()
                ],
            }
            values["model-index"] = [{"name": self.name, "results": [results]}]
        # JSON is YAML as well, and needs no writer of its own.
        header = "".join(f"{key}: {json.dumps(value)}\n" for key, value in values.items())
        body = "".join(f"\n## {title}\n\n{text}\n" for title, text in self.sections.items() if text)
        return f"---\n{header}---\n\n# {self.name}\n\n{self.summary}\n{body}"


def hub_license(given: str | None, recorded: str | None) -> str:
    """The licence that a card states, in the hub's spelling.

    Args:
        given: What the user names.
        recorded: What is recorded of the model, an SPDX name.

    Raises:
        ConfigurationError: Neither is there, it is no such name, or the two differ.
    """
    known = None if recorded is None else recorded.lower()
    name = given or known
    if name is None:
        raise ConfigurationError(
            "the licence of these weights is not recorded: --license names it as the hub does, "
            "such as mit, cc-by-nc-sa-4.0 or other"
        )
    if not _LICENSE.fullmatch(name) or (known is not None and name != known):
        also = f", and {known} is recorded" if known else ""
        raise ConfigurationError(
            f"--license is a name of the hub such as mit or cc-by-nc-sa-4.0, got {name!r}{also}"
        )
    return name


def facts_table(facts: Mapping[str, Any]) -> str:
    """A Markdown table of what is known; empty values are left out."""
    rows = {
        name.replace("_", " "): value if isinstance(value, str) else json.dumps(value)
        for name, value in facts.items()
        if value not in (None, "", {}, [])
    }
    lines = [f"| {name} | `{value}` |" for name, value in rows.items()]
    return "\n".join(["| what | value |", "|---|---|", *lines])
