"""The reference of the public library: the modules that the documentation or the registry names.

A module that no page names may change at any time, and has no page here.
"""

from __future__ import annotations

import inspect
import re
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from repository import ROOT, address
from written_pages import write_changed

import avsec_gym
from avsec_gym.built_in_parts import BUILT_IN
from avsec_gym.registration import CATALOGUE

_NAME = re.compile(r"\bavsec_gym(?:\.\w+)+")
_ENVIRONMENTS = {entry.entry_point.partition(":")[0] for entry in CATALOGUE}
"""They have pages of their own."""
_HEAD = """# API reference

The modules that the documentation or the registry of parts names: these are public, and the
changelog names what changes in them. Others may change at any time. Environments have
[pages of their own](../envs/index.md), and [parts](../parts.md) are listed by their names.
"""


def write_pages(source: Path) -> set[Path]:
    """Write a page for each public module, and lists of them by room; returns the files."""
    modules = public_modules()
    written = {
        write_changed(source / f"{place_of(module)}.rst", _page(module).encode())
        for module in modules
    }
    text, room = _HEAD, ""
    for module in modules:
        if module.split(".")[1] != room:
            room = module.split(".")[1]
            text += f"\n## avsec_gym.{room}\n\n"
        text += f"- [`{module}`]({module}.rst): {_summary(module)}\n"
    return written | {write_changed(source / "api/index.md", text.encode())}


def place_of(module: str) -> str:
    """Where a module's page is, without its ending."""
    return f"api/{module}"


@cache
def public_modules() -> tuple[str, ...]:
    """Their names, sorted; those whose extra is not installed are left out."""
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    texts = [page.read_text(encoding="utf-8") for page in pages]
    for module in _ENVIRONMENTS:
        texts.append(inspect.getsource(import_module(module)).split('"""\n\n    title')[0])
    named = {name for text in texts for name in _NAME.findall(text)}
    named |= {path.partition(":")[0] for path, _ in BUILT_IN.values()} | {"avsec_gym.registry"}
    modules = {module for name in named if (module := _module_of(name))}
    for package in [avsec_gym, *map(import_module, sorted(modules))]:
        # What a package offers is documented where it is defined.
        for each in getattr(package, "__all__", ()):
            modules.add(getattr(getattr(package, each), "__module__", package.__name__))
    return tuple(
        sorted(
            module
            for module in modules - _ENVIRONMENTS - {"avsec_gym"}
            if module.startswith("avsec_gym") and _is_worth_a_page(module)
        )
    )


def _module_of(name: str) -> str:
    """The module of a dotted name; empty if the name is of none, or its extra is missing."""
    while "." in name:
        try:
            if find_spec(name) is not None:
                import_module(name)
                return name
        except ModuleNotFoundError as error:
            if not (error.name or "").startswith("avsec_gym"):
                return ""
        name = name.rpartition(".")[0]
    return ""


def _is_worth_a_page(module: str) -> bool:
    """Whether it defines something public."""
    return any(
        getattr(what, "__module__", None) == module and not name.startswith("_")
        for name, what in vars(import_module(module)).items()
    )


def _summary(module: str) -> str:
    """The first line of its docstring."""
    return (inspect.getdoc(import_module(module)) or "").splitlines()[0]


def _page(module: str) -> str:
    """It is no part of the sidebar, which would be long, and drawn anew for every page."""
    code = Path(inspect.getfile(import_module(module)))
    return (
        f":orphan:\n\n{module}\n{'=' * len(module)}\n\n:doc:`API reference </api/index>`"
        f" · `source <{address(code)}>`__\n\n"
        f".. automodule:: {module}\n   :members:\n   :show-inheritance:\n"
    )
