"""The drives in which it matters what a car sees: finds them by rule, and drives them.

    python -m studies.driving_safety.contested_drives find --seed 17 --count 50 --out FILE
    python -m studies.driving_safety.contested_drives drive --of FILE --settings truth blind ...

`avsec_gym.drives.contested_drives` has the rule.  Elsewhere detectors and attacks differ by little,
and an error model that is never put to the test passes.  `drive` is `avsec drive` with these
scenes: it takes all other options of that.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from avsec_gym import console
from avsec_gym.cli import run
from avsec_gym.drives.contested_drives import contested_drives
from avsec_gym.errors import DataError
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.text_files import write_text
from studies.answer import exit_code

MOST_SCENES = 5000
"""Procedural drives that are looked at, at most; some four in a hundred are contested."""
_REMEDY = "Run `contested_drives find` again."


@dataclass(frozen=True)
class ContestedDrives:
    """What was found.

    Args:
        scenarios: The procedural drives, as the environment takes them.
        ids: The contested ones of them.
        looked_at: Number of drives that were looked at for these.
    """

    scenarios: dict[str, Any]
    ids: Sequence[str]
    looked_at: int


def find_contested(scenarios: dict[str, Any], count: int) -> ContestedDrives:
    """The first contested drives.

    Args:
        scenarios: The procedural drives, as the environment takes them.
        count: How many are wanted.

    Raises:
        DataError: There are fewer.
    """
    found: list[str] = []
    with console.progress("contested drives") as shown:
        for number, id in contested_drives(scenarios):
            found.append(id)
            shown(len(found), count)
            if len(found) == count:
                return ContestedDrives(scenarios, found, number + 1)
    raise DataError(f"Of {scenarios['count']} drives, {len(found)} are contested.")


def read_contested(path: Path) -> ContestedDrives:
    """What `find` wrote.

    Args:
        path: Its file.

    Raises:
        DataError: The file is missing or broken.
    """
    return ContestedDrives(**read_json_object(path, remedy=_REMEDY))


def drive_words(found: ContestedDrives, first: int | None) -> list[str]:
    """The words of `avsec drive` that name the scenes.

    Args:
        found: The contested drives.
        first: How many of them are driven, the first ones; None: all.
    """
    return ["drive", "--scenarios", json.dumps(found.scenarios), "--ids", *found.ids[:first]]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parts = parser.add_subparsers(dest="part", required=True)
    finding = parts.add_parser("find", help="look for contested drives")
    finding.add_argument("--seed", type=int, required=True, help="of the procedural drives")
    finding.add_argument("--count", type=int, required=True, help="of contested drives")
    finding.add_argument("--out", type=Path, required=True, help="the file of their ids")
    driving = parts.add_parser("drive", help="`avsec drive` with these scenes", allow_abbrev=False)
    driving.add_argument("--of", type=Path, required=True, help="the file of their ids")
    driving.add_argument("--first", type=int, help="drive only so many")
    options, others = parser.parse_known_args(arguments)
    if options.part == "drive":
        return run([*drive_words(read_contested(options.of), options.first), *others])
    if others:
        parser.error(f"unknown words: {' '.join(others)}")

    def find() -> None:
        scenarios = {
            "source": "drives",
            "seed": options.seed,
            "assets": "judge",
            "count": MOST_SCENES,
        }
        found = find_contested(scenarios, options.count)
        options.out.parent.mkdir(parents=True, exist_ok=True)
        write_text(options.out, json.dumps(asdict(found), indent=1) + "\n", overwrite=True)

    return exit_code(find)


if __name__ == "__main__":
    sys.exit(main())
