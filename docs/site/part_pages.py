"""A page of all parts that have a name: detectors, attacks, planners, and the rest."""

from __future__ import annotations

import inspect
from importlib import import_module
from pathlib import Path

from api_pages import place_of
from written_pages import write_changed

from avsec_gym.built_in_parts import BUILT_IN, Kind
from avsec_gym.registry import _factory

_HEAD = """# Parts by name

Wherever a command, an environment or an experiment takes one of these parts, it takes its name, a
dictionary such as `{"name": "astar", "node_limit": 1000}`, or the object itself.
[A package of your own](extending.md) adds more of them.
"""


def write_pages(source: Path) -> set[Path]:
    """Write it; returns the file."""
    text = _HEAD
    for kind in Kind:
        names = [name for known, name in BUILT_IN if known == kind]
        title = kind.words[0].upper() + kind.words[1:]
        text += f"\n## {title}\n\n| name | is | arguments |\n|---|---|---|\n"
        text += "".join(
            f"| `{each}` | {_is(kind, each)} | {_takes(kind, each)} |\n" for each in names
        )
    return {write_changed(source / "parts.md", text.encode())}


def _is(kind: Kind, name: str) -> str:
    """The first line of its docstring, and its page."""
    factory, _, _ = _factory(kind, name)
    # Of a class without a docstring of its own, Python would give that of the base.
    own = factory.__doc__ or import_module(factory.__module__).__doc__ or ""
    summary = inspect.cleandoc(own).split("\n\n")[0]
    return f"{' '.join(summary.split())} [API]({place_of(factory.__module__)}.rst)"


def _takes(kind: Kind, name: str) -> str:
    """Its arguments with their defaults."""
    factory, given, _ = _factory(kind, name)
    taken = []
    for each in inspect.signature(factory).parameters.values():
        default = given.get(each.name, each.default)
        shown = f"{each.name}" if default is each.empty else f"{each.name}={default!r}"
        taken.append(f"`{shown}`".replace("|", r"\|"))
    return ", ".join(taken)
