"""Damages files of every kind that users give, and counts what becomes of them; prints JSON.

    python benchmarks/fuzz --files 1000 --seed 7 [--kinds label scan] [--keep DIR] [--out FILE]
                           [--done FILE]

Each file is a sound one that one to three mutators changed, or that something else replaces. A
process reads it as the commands do. Allowed outcomes are ``read``, where what was read is possible,
and ``refused``, by an error of this project that names the file. Everything else is a fault, and
ends with exit code 1: ``traceback`` (another error), ``impossible`` (read, though it holds what no
sound file holds), ``nameless`` (refused without a name), ``memory``, ``hang``, ``died``.

Stopped, and given the same command with ``--done``, it goes on after the kinds that were done, if
no source has changed since.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from random import Random
from typing import Any

from done import DoneKinds
from kinds import KINDS, Kind
from page import page
from patience import answers_in
from reader import MOST_MEMORY
from replace_file import REPLACEMENTS

ALLOWED = ("read", "refused")
FAULTS = ("traceback", "impossible", "nameless", "memory", "hang", "died")
PATIENCE = 30.0
"""Seconds for a file of a few kilobytes; the slowest sound one takes a tenth of one."""
FIRST_PATIENCE = 10 * PATIENCE
"""Seconds for a process's first file, with its imports and kernels that are compiled on the way."""
_LARGE = 500_000
"""Bytes; a file that has grown so large is not changed further."""
_REPLACED = 0.06
"""The share of files that something else stands in place of."""


def main() -> int:
    """Damage, read, count."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--files", type=int, default=1000, help="of each kind")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kinds", nargs="*", default=list(KINDS), choices=list(KINDS))
    parser.add_argument("--jobs", type=int, default=2, help="kinds at once")
    parser.add_argument("--keep", type=Path, help="folder for the files with a fault")
    parser.add_argument("--done", type=Path, help="file that keeps what is done")
    parser.add_argument("--out", type=Path, help="file for the JSON, and a page beside it")
    arguments = parser.parse_args()
    begun = time.monotonic()
    counts, faults = {}, []
    done = DoneKinds(arguments.done, files=arguments.files, seed=arguments.seed)

    def counted(name: str) -> tuple[Counter[str], list[dict[str, Any]]]:
        if (known := done.get(name)) is not None:
            return known
        found = fuzz(KINDS[name], arguments.files, arguments.seed, arguments.keep)
        done.add(name, *found)
        return found

    # A thread for each kind that is under way: the reading is done in processes.
    with ThreadPoolExecutor(arguments.jobs) as pool:
        results = pool.map(counted, arguments.kinds)
        for number, (name, (found, wrong)) in enumerate(
            zip(arguments.kinds, results, strict=True), 1
        ):
            counts[name] = {word: found[word] for word in (*ALLOWED, *FAULTS)}
            faults += wrong
            spent = time.monotonic() - begun
            left = spent / number * (len(arguments.kinds) - number)
            outcomes = ", ".join(f"{count} {word}" for word, count in found.items())
            print(
                f"{number}/{len(arguments.kinds)} {name}: {outcomes}"
                f" ({spent:.0f} s, {left:.0f} s left)",
                file=sys.stderr,
            )
    total = {word: sum(row[word] for row in counts.values()) for word in (*ALLOWED, *FAULTS)}
    result = {
        "files_of_each_kind": arguments.files,
        "seed": arguments.seed,
        "total": total,
        "kinds": counts,
        "faults": faults,
    }
    text = json.dumps(result, indent=1)
    print(text)
    if arguments.out is not None:
        arguments.out.write_text(text + "\n")
        arguments.out.with_suffix(".md").write_text(page(result, MOST_MEMORY, PATIENCE))
    return int(any(total[word] for word in FAULTS))


def fuzz(
    kind: Kind, files: int, seed: int, keep: Path | None = None
) -> tuple[Counter[str], list[dict[str, Any]]]:
    """Outcomes of a kind's damaged files, and the faults among them.

    Raises:
        SystemExit: The sound file is not read.
    """
    counts: Counter[str] = Counter()
    faults = []
    with tempfile.TemporaryDirectory(prefix="fuzz") as place:
        sound = Path(place) / "sound"
        sound.mkdir()
        kind.make(sound)
        reader = None
        for index in range(files):
            if reader is None:
                reader = _Reader(kind)
                first = reader.read(_copied(sound, Path(place) / "first"), FIRST_PATIENCE)
                if first["outcome"] != "read":
                    raise SystemExit(f"a sound {kind.name} is not read: {first}")
            folder = _copied(sound, Path(place) / f"case{index}")
            how = damage(kind, folder / kind.file, Random(f"{seed}/{kind.name}/{index}"))
            outcome = reader.read(folder)
            counts[outcome["outcome"]] += 1
            if outcome["outcome"] not in ALLOWED:
                faults.append({"kind": kind.name, "index": index, "how": how, **outcome})
                if keep is not None:
                    target = keep / kind.name.replace(" ", "_") / str(index)
                    shutil.rmtree(target, ignore_errors=True)
                    shutil.copytree(folder, target, symlinks=True, ignore=_pipes)
            if outcome["outcome"] in ("hang", "died", "memory"):
                reader.end()
                reader = None
            shutil.rmtree(folder)
        if reader is not None:
            reader.end()
    return counts, faults


def damage(kind: Kind, path: Path, random: Random) -> list[str]:
    """Change a file; returns by which mutators."""
    if random.random() < _REPLACED:
        name = random.choice(list(REPLACEMENTS))
        REPLACEMENTS[name](path, random)
        return [name]
    content = sound = path.read_bytes()
    names = []
    while content == sound and len(names) < 10:
        for name in random.choices(list(kind.mutators), k=random.choice((1, 1, 1, 2, 3))):
            if len(content) > _LARGE:
                break  # Searching through it takes the mutators too long.
            try:
                content = kind.mutators[name](content, random)
            except Exception:
                if content == sound:
                    raise
                continue  # What an earlier mutator left has no such structure any more.
            names.append(name)
    path.write_bytes(content)
    return names


class _Reader:
    """A process that reads files of one kind."""

    def __init__(self, kind: Kind) -> None:
        here = Path(__file__).parent
        self._process = subprocess.Popen(
            [sys.executable, str(here / "reader.py"), kind.name],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip

    def read(self, folder: Path, patience: float = PATIENCE) -> dict[str, Any]:
        """The outcome of a folder; no answer in `patience` seconds of its own is a hang."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            self._process.stdin.write(f"{folder}\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            return {"outcome": "died", "detail": f"exit code {self._process.wait()}"}
        if not answers_in(self._process.stdout, self._process.pid, patience):
            return {"outcome": "hang", "detail": f"no answer in {patience:.0f} s"}
        line = self._process.stdout.readline()
        if not line:
            return {"outcome": "died", "detail": f"exit code {self._process.wait()}"}
        return dict(json.loads(line))

    def end(self) -> None:
        """No more files."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()


def _copied(sound: Path, folder: Path) -> Path:
    return Path(shutil.copytree(sound, folder, dirs_exist_ok=True))


def _pipes(folder: str, names: list[str]) -> list[str]:
    """What cannot be copied: pipes, and files of 64 GiB."""
    paths = [path for name in names if not (path := Path(folder, name)).is_dir()]
    return [path.name for path in paths if not path.is_file() or path.stat().st_size > 2**30]


if __name__ == "__main__":
    sys.exit(main())
