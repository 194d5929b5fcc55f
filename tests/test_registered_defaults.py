"""What a registered part does unless told otherwise: whoever changes a default changes results.

`registered_defaults.json` lists the defaults.  Where one changes on purpose, the list is written
anew (``python -m tests.test_registered_defaults``), the versions of environments whose results
change are raised, and the changelog says so.
"""

from __future__ import annotations

import json
from inspect import Parameter, signature
from pathlib import Path
from typing import Any

from avsec_gym.built_in_parts import BUILT_IN
from avsec_gym.registry import _factory

LIST = Path(__file__).with_name("registered_defaults.json")


def defaults_of_all() -> dict[str, dict[str, str]]:
    """As Python writes them, by kind and name of the part and by argument."""
    return {f"{kind} {name}": _defaults(*_factory(kind, name)[:2]) for kind, name in BUILT_IN}


def _defaults(factory: Any, given: dict[str, Any]) -> dict[str, str]:
    known = {
        name: parameter.default
        for name, parameter in signature(factory).parameters.items()
        if parameter.default is not Parameter.empty
    }
    return {name: repr(value) for name, value in (known | given).items()}


def test_defaults_are_those_of_the_list() -> None:
    listed, found = json.loads(LIST.read_text()), defaults_of_all()
    changed = {part: found.get(part) for part in {*listed, *found}
               if listed.get(part) != found.get(part)}  # fmt: skip
    assert not changed, "see this module's docstring"


def test_the_list_holds_values_alone() -> None:
    """No address of an object and no path of a machine: they differ from run to run."""
    for part, arguments in defaults_of_all().items():
        for name, value in arguments.items():
            assert " at 0x" not in value, (part, name)
            assert str(Path.home()) not in value, (part, name)
            assert str(Path(__file__).parents[1]) not in value, (part, name)


if __name__ == "__main__":
    text = json.dumps(dict(sorted(defaults_of_all().items())), indent=1)
    LIST.write_text(text + "\n", encoding="utf-8")
