"""Search the best constant action of every attacker, with the default arguments; prints JSON.

    python -m studies.attackers.constants --runs runs/constants --json constants.json

An agent that does not look does the same in every episode.  Its action is searched by a grid,
random actions and CMA-ES (`avsec_gym.agents.search.best_constant`) on some scenes, and judged by
others of the same kind.  A game in which it wins more than 35 % states so in its first paragraph:
`tests/envs/test_constants_that_win.py` holds the docstrings against this result.

A game that is finished is kept in --runs, so that a command that was stopped goes on there.  Remove
the folder where sources have changed.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from avsec_gym.console import progress
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.storage.json_files import read_json
from avsec_gym.storage.regular_files import is_file
from avsec_gym.storage.text_files import write_text
from avsec_gym.worker_processes import each_in_processes
from studies.answer import answer
from studies.attackers.attacked_games import GAMES, asked, searching


def search(options: argparse.Namespace) -> dict[str, Any]:
    """Search what is not kept, and put all together.

    Args:
        options: Those of `main`.
    """
    names = options.games or list(GAMES)
    waiting = [name for name in names if not _is_kept(options, name)]
    work = each_in_processes(
        partial(searching, options.seed), waiting, options.workers, threads=1, folder=options.runs
    )
    with progress("games") as shown:
        for done, (name, found) in enumerate(work, start=1):
            kept = {"asked": asked(name, options.seed), "found": as_json(found)}
            write_text(_place(options, name), json.dumps(kept, indent=1) + "\n", overwrite=True)
            shown(done, len(waiting))
    return {"seed": options.seed, "games": {name: _kept(options, name)["found"] for name in names}}


def _is_kept(options: argparse.Namespace, name: str) -> bool:
    if not is_file(_place(options, name)):
        return False
    plain = json.loads(json.dumps(asked(name, options.seed)))
    return bool(_kept(options, name)["asked"] == plain)


def _kept(options: argparse.Namespace, name: str) -> Any:
    return read_json(_place(options, name), remedy="Remove it, and it is made anew.")


def _place(options: argparse.Namespace, name: str) -> Path:
    folder: Path = options.runs
    return folder / f"{name.replace(', ', '_').replace(' ', '_')}.json"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("games", nargs="*", metavar="GAME", help=f"some of {', '.join(GAMES)}")
    parser.add_argument("--seed", type=int, default=0, help="of the searches")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--runs", type=Path, required=True, help="folder of what is kept")
    parser.add_argument("--json", type=Path, help="file of the result; without: standard output")
    options = parser.parse_args(arguments)
    if unknown := [name for name in options.games if name not in GAMES]:
        parser.error(f"there is no game {unknown[0]!r}; there are {', '.join(GAMES)}")
    return answer(options, search)


if __name__ == "__main__":
    sys.exit(main())
