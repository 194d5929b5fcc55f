"""Which tests try a module?  For those that have no test of their own name.

    python tests/which.py avsec_gym/world/road/loft.py
    python tests/which.py avsec_gym.planners.search_tree

Prints the tests of the module's name, then those whose imports lead to it, the nearest first.
"""

from __future__ import annotations

import argparse
import ast
import re
from collections import deque
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = "avsec_gym"


def nearest_tests(module: str, most: int = 10) -> list[tuple[int, str]]:
    """Steps of imports from a test to the module, with the test's path; the nearest come first.

    A test of the module's name is 0 steps away.  Of those equally near, the one comes first whose
    name has most words of the module's, and then the one that lies where the module does.

    Args:
        module: Its dotted name.
        most: How many tests.
    """
    name = module.rpartition(".")[2]
    words = set(name.split("_"))
    mirrored = Path("tests", *module.split(".")[1:]).parent
    found = []
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        inside = path.relative_to(ROOT)
        named = re.fullmatch(f"test_{name}(_command)?", path.stem)
        steps = 0 if named else steps_from(path).get(module)
        if steps is not None:
            shared = len([0 for a, b in zip(mirrored.parts, inside.parts, strict=False) if a == b])
            found.append((steps, -len(words & set(path.stem.split("_"))), -shared, str(inside)))
    return [(steps, path) for steps, *_, path in sorted(found)[:most]]


def modules() -> list[str]:
    """All modules of the package, without those that only gather others."""
    paths = sorted((ROOT / PACKAGE).rglob("*.py"))
    return [_module(path) for path in paths if not path.stem.startswith("__")]


@cache
def steps_from(test: Path) -> dict[str, int]:
    """Every module that a test's imports lead to, and in how many steps."""
    steps: dict[str, int] = {}
    waiting = deque((name, 1) for name in _imported(test))
    while waiting:
        name, distance = waiting.popleft()
        if name not in steps:
            steps[name] = distance
            waiting.extend((each, distance + 1) for each in _imported(_paths()[name]))
    return steps


@cache
def _imported(path: Path) -> frozenset[str]:
    """The package's modules that a file imports; of what a package gathers, the one that has it."""
    text = path.read_text()
    beside = _module(path.with_name("__init__.py")) if "import_module" in text else PACKAGE
    names = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {_home(node.module, alias.name) for alias in node.names}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            # What is loaded when it is asked for: "avsec_gym.game:Game", or a file beside.
            names |= {node.value.partition(":")[0], f"{beside}.{node.value}"}
    return frozenset(names & _paths().keys())


@cache
def _home(module: str, name: str) -> str:
    """The module that `from module import name` gets its name from."""
    if f"{module}.{name}" in _paths():
        return f"{module}.{name}"
    path = _paths().get(module)
    if path is not None and path.name == "__init__.py":
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.ImportFrom) and node.module and node.module != module:
                for alias in node.names:
                    if (alias.asname or alias.name) == name:
                        return _home(node.module, alias.name)
    return module


@cache
def _paths() -> dict[str, Path]:
    return {_module(path): path for path in (ROOT / PACKAGE).rglob("*.py")}


def _module(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _lines(module: str) -> Iterator[str]:
    for steps, path in nearest_tests(module):
        yield f"{path}  ({'of its name' if steps == 0 else f'{steps} imports away'})"


def main() -> None:
    """Print a module's tests."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("module", help="a file or a dotted name")
    given = parser.parse_args().module
    module = _module(Path(given).resolve()) if given.endswith(".py") else given
    if module not in _paths():
        parser.error(f"there is no module {module}: give a file or a dotted name of {PACKAGE}")
    print("\n".join(_lines(module)) or f"no test imports {module}")


if __name__ == "__main__":
    main()
