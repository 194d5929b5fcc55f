"""The floors of the house, drawn from the contract that `make lint` checks.

    python docs/floors.py            # writes the picture into docs/architecture.md
    python docs/floors.py --check    # fails where it differs

The contract stands in pyproject.toml, under ``tool.importlinter``.
"""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs/architecture.md"
BEGIN, END = "<!-- floors: python docs/floors.py -->\n", "<!-- end of floors -->"
WIDTH = 92


def picture() -> str:
    """A line for each floor, the highest first: its name, and what its docstring states."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())
    floors = next(
        contract["layers"]
        for contract in settings["tool"]["importlinter"]["contracts"]
        if "containers" in contract
    )
    lines = [_line("studies/", ROOT / "studies/__init__.py")]
    for floor in floors:
        modules = floor.split(" : ")
        if len(modules) > 1:
            lines += ["-" * WIDTH, *_wrapped([f"{module}.py" for module in modules])]
        elif floor != "__main__":
            folder = ROOT / "avsec_gym" / floor
            package = folder.is_dir()
            source = folder / "__init__.py" if package else folder.with_suffix(".py")
            lines.append(_line(f"{floor}/" if package else f"{floor}.py", source))
    return "```\n" + "\n".join(lines) + "\n```\n"


def _line(name: str, source: Path) -> str:
    first = source.read_text().split('"""')[1].splitlines()[0]
    return f"{name:<19}{first}"


def _wrapped(names: list[str]) -> list[str]:
    lines = [""]
    for name in names:
        if len(lines[-1]) + len(name) + 2 > WIDTH:
            lines.append("")
        lines[-1] += f"{name}  "
    return [line.rstrip() for line in lines]


def main() -> int:
    """Write the picture, or compare."""
    text = PAGE.read_text()
    before, rest = text.split(BEGIN)
    new = before + BEGIN + picture() + END + rest.split(END)[1]
    if "--check" in sys.argv:
        return int(new != text)
    PAGE.write_text(new)
    return 0


if __name__ == "__main__":
    sys.exit(main())
