"""Which changes of the code do the tests see?  A random sample of mutants, tested one by one.

    python tests/mutants.py                        # 300 mutants, about two hours; prints JSON
    python tests/mutants.py --count 40 --seed 7 --only planners metrics
    python tests/mutants.py --keep mutants.jsonl   # goes on where it was stopped; what survived and
                                                   # what has other code since are tried again
    python tests/mutants.py --jobs 2               # two at a time

cosmic-ray (extra ``mutants``) changes one operator, number or keyword of a module, in a copy of the
repository.  The fast tests of the module's room that execute the changed line (by coverage without
the change) are run, those of the module's name first, then the nearest of other rooms; of each of
the two the first ones, as many as end in 90 s.  A mutant that all of them pass survives.  What
changes no result is left alone: what an error says, ``strict=``, ``nogil=``, ``frozen=``,
decorators of kernels and of what is kept, ``is`` to ``==``.  Kernels run as plain Python
(``NUMBA_DISABLE_JIT=1``), and by the tests nearest to them alone; for what those let pass, tests
that take too long without compilation are run with it.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import hashlib
import json
import os
import pickle
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from functools import cache
from itertools import accumulate, islice
from pathlib import Path
from queue import SimpleQueue
from threading import Lock
from types import MappingProxyType
from typing import Any

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

from avsec_gym.storage.source_code import code_of

ROOT = Path(__file__).parents[1]
ROOMS = ("attacks", "metrics", "planners", "validation", "pipeline.py")
PATIENCE = 3.0
"""As many times their usual duration, and a minute, after which tests count as failed: a mutant
may loop for ever."""
NEAREST = 8
"""So many files of tests are run where not all of a room's are."""
KEPT: Path | None = None
"""The folder beside `--keep` in which this process keeps what tests do without a mutant."""
LONGEST = 90.0
"""Seconds after which the nearest file of tests is left out where kernels are Python; the second
gets half of it, the third a third."""
WHOLE_PACKAGE = ("tests/test_registered_defaults.py", "tests/test_compared_by_identity.py")
"""Tests that look at all modules, and so execute no line of one: what all others let pass meets
them."""
SLOW, COMPILED = 3, 600.0
"""So many files of tests that were left out so are run with compilation; seconds for each."""
ENOUGH = 90.0
"""Seconds of tests, usually, after which a mutant that passed them counts as survived."""
_ONE_AT_A_TIME: dict[tuple[bool, tuple[str, ...]], Lock] = defaultdict(Lock)
_KEYWORDS = ("strict", "nogil", "frozen")
_SAME = ("ReplaceComparisonOperator_Is_Eq", "ReplaceComparisonOperator_IsNot_NotEq")
"""Operators that change nothing: only None, True, False and members of enumerations are compared by
identity here."""
_FASTER = re.compile(r"(kernel|cache|lru_cache|register_jitable)\b")
"""Decorators that change the speed alone."""
PASSED = (0, 5)
"""What pytest ends with where nothing failed, or there was no test."""


@dataclass(frozen=True)
class Mutant:
    """One change of one module."""

    module: str
    operator: str
    occurrence: int
    line: int


def all_mutants(rooms: list[str], seed: int) -> Iterator[Mutant]:
    """In random order, each place of the code once, with one of the operators that apply there.

    A place has its rank by a hash of its line, so that a change of the code elsewhere leaves the
    order of all others as it was, and with it the sample.
    """
    import cosmic_ray.plugins as plugins
    from cosmic_ray.ast import ast_nodes, get_ast_from_path

    places: dict[tuple[str, Any], list[Mutant]] = {}
    operators = {name: plugins.get_operator(name) for name in plugins.operator_names()}
    for path in sorted(p for room in rooms for p in _modules(room)):
        module, tree = str(path.relative_to(ROOT)), get_ast_from_path(path)
        silent = _annotations(path)
        for name, kind in operators.items():
            if kind.arguments() or name.endswith(_SAME):
                continue
            found = (span for node in ast_nodes(tree) for span in kind().mutation_positions(node))
            for occurrence, (start, end) in enumerate(found):
                if not any(first <= start and end <= last for first, last in silent):
                    mutant = Mutant(module, name, occurrence, start[0])
                    places.setdefault((module, start), []).append(mutant)
    ranks = _ranks(places, seed)
    for module, start in sorted(places, key=lambda place: ranks[place]):
        found = places[module, start]
        mutant = found[int(ranks[module, start], 16) % len(found)]
        checks = _checks_alone(ROOT / module)
        if not any(first <= start < end for first, end in checks):
            yield mutant


def _ranks(places: Iterable[tuple[str, tuple[int, int]]], seed: int) -> dict[Any, str]:
    """A hash for each place: of the seed, the module, the line and where in it the place is."""
    ranks, equal_lines = {}, Counter[tuple[str, str, int]]()
    for module, (line, column) in sorted(places):
        text = _lines(module)[line - 1]
        place = module, text.strip(), column - len(text) + len(text.lstrip())
        equal_lines[place] += 1
        asked = f"{seed} {place} {equal_lines[place]}"
        ranks[module, (line, column)] = hashlib.sha256(asked.encode()).hexdigest()
    return ranks


@cache
def _lines(module: str) -> list[str]:
    return (ROOT / module).read_text().splitlines()


def _modules(room: str) -> list[Path]:
    path = ROOT / "avsec_gym" / room
    return [path] if path.is_file() else list(path.rglob("*.py"))


def _annotations(path: Path) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Spans that nothing evaluates: annotations."""
    spans = []
    for node in ast.walk(ast.parse(path.read_text())):
        for name in ("annotation", "returns"):
            part = getattr(node, name, None)
            if part is not None:
                spans.append(
                    ((part.lineno, part.col_offset), (part.end_lineno, part.end_col_offset))
                )
    return spans


@cache
def _checks_alone(path: Path) -> tuple[tuple[tuple[int, int], tuple[int, int]], ...]:
    """Spans that change no result: what errors say, ``strict=`` of `zip`, ``nogil=`` of kernels,
    ``frozen=`` of classes, and what only makes functions faster: ``@kernel``, ``@cache``."""
    spans = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Raise) or (isinstance(node, ast.keyword) and node.arg in _KEYWORDS):
            spans.append(node)
        elif isinstance(node, ast.FunctionDef):
            spans += [each for each in node.decorator_list if _FASTER.match(ast.unparse(each))]
    # A decorator begins with its sign, which is no part of the expression.
    return tuple(
        ((node.lineno, node.col_offset - 1), (node.end_lineno or 0, node.end_col_offset or 0))
        for node in spans
    )


@cache
def tests_of(module: str, kernels: bool) -> tuple[tuple[str, ...], ...]:
    """The tests of a module's room, and the nearest of other rooms, for what those let pass.

    Of a room of one file, those nearest to it alone; where kernels are slow, being Python, likewise
    and only of the room.
    """
    room = Path("tests", Path(module).parts[1])
    command = [sys.executable, str(ROOT / "tests/which.py"), module]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    nearest = [line.split()[0] for line in lines.splitlines()]
    if room.suffix:
        return (tuple(nearest[:NEAREST]),)
    own = [test for test in nearest if Path(test).is_relative_to(room)]
    if kernels:
        return (tuple(own[:NEAREST]),)
    others = tuple(test for test in nearest if test not in own)[:NEAREST]
    return ((str(room),), others) if others else ((str(room),),)


def killed_by(copy: Path, kernels: bool, mutant: Mutant) -> str:
    """The test that fails; empty if the mutant survives."""
    groups = tests_of(mutant.module, kernels)
    found = (_killed_by(copy, kernels, mutant, group) for group in groups)
    by = next(filter(None, found), "") or _killed_by_files(copy, WHOLE_PACKAGE)
    return by or (_killed_compiled(copy, mutant) if kernels else "")


def _killed_compiled(copy: Path, mutant: Mutant) -> str:
    """The test that fails of those that take too long without compilation."""
    [group] = tests_of(mutant.module, kernels=True)
    timed = {_file(name) for name in unmutated(True, group).seconds}
    slow = [test for test in group if test not in timed]
    return _killed_by_files(copy, slow[:SLOW])


def _killed_by_files(copy: Path, files: Sequence[str]) -> str:
    """The test that fails of whole files, with compilation."""
    for test in files:
        try:
            done = ran(pytest_of("-x", "-rfE", "--tb=no", test), copy, False, COMPILED)
        except subprocess.TimeoutExpired:
            return f"{test} (time)"
        if done.returncode not in PASSED:
            return next(iter(failures(done.stdout)), done.stdout[-200:])
    return ""


def _of_its_name(module: str, group: Sequence[str]) -> list[str]:
    """The files of tests below those of a group that have a module's name."""
    name = f"test_{Path(module).name}"
    places = [ROOT / test for test in group]
    files = {file for place in places for file in ([place], place.rglob(name))[place.is_dir()]}
    return sorted(str(file.relative_to(ROOT)) for file in files if file.name == name)


def _killed_by(copy: Path, kernels: bool, mutant: Mutant, group: tuple[str, ...]) -> str:
    usual = unmutated(kernels, group)
    tests = usual.first_of(usual.that_execute(mutant), ENOUGH)
    if not tests:
        # A module of numbers alone is executed when it is imported, by no test.
        return _killed_by_files(copy, _of_its_name(mutant.module, group))
    left_out = [word for name in usual.failed for word in ("--deselect", name)]
    command = pytest_of("-x", "-rfE", "--tb=no", *left_out, *tests)
    try:
        done = ran(command, copy, kernels, PATIENCE * usual.duration(tests) + 60.0)
    except subprocess.TimeoutExpired:
        return f"{tests[0]} (time)"
    if done.returncode in PASSED:
        return ""
    return next(iter(failures(done.stdout)), done.stdout[-200:])


@dataclass(frozen=True)
class Unmutated:
    """What tests do without a mutant."""

    seconds: dict[str, float]
    """By test: how long it takes."""
    failed: tuple[str, ...]
    """Those that fail, such as by a limit of time where kernels are Python: they tell nothing of a
    mutant, and are left out."""
    executed: dict[str, dict[int, list[str]]]
    """By module and line: the tests that execute it, ``test|setup``, ``test|run``; an empty one
    where an import does."""

    def that_execute(self, mutant: Mutant) -> list[str]:
        """The tests that execute a mutant's statement, those of its module's name first, then files
        that take a short time.

        Where an import executes it, the tests that execute any line of the module; a whole file
        where one of its fixtures does, since other tests may share the fixture.
        """
        lines = self.executed.get(mutant.module, {})
        contexts = {each for line in statement(mutant) for each in lines.get(line, ())}
        if "" in contexts:
            contexts = {each for line in lines.values() for each in line}
        tests = {name for name, _, phase in map(_parts, contexts) if phase == "run"}
        files = {file for _, file, phase in map(_parts, contexts) if file and phase != "run"}
        tests = files | {name for name in tests if _file(name) not in files}
        cost: dict[str, float] = {}
        for name in tests:
            cost[_file(name)] = cost.get(_file(name), 0.0) + self.duration([name])
        mirror = f"/test_{Path(mutant.module).name}"
        return sorted(
            tests,
            key=lambda name: (not _file(name).endswith(mirror), cost[_file(name)], name),
        )

    def first_of(self, tests: Sequence[str], seconds: float) -> list[str]:
        """The first of some tests, as many as usually end in a time; the very first in any case."""
        ends = accumulate(self.duration([name]) for name in tests)
        first = [name for name, end in zip(tests, ends, strict=True) if end <= seconds]
        return first or list(tests[:1])

    def duration(self, tests: Sequence[str]) -> float:
        """How long tests and files take, in seconds."""
        asked = set(tests)
        known = self.seconds.items()
        return sum(taken for name, taken in known if name in asked or _file(name) in asked)


def _parts(context: str) -> tuple[str, str, str]:
    """A context of pytest-cov, ``file::test|phase``: the test, its file, its phase."""
    name, _, phase = context.rpartition("|")
    return name, _file(name), phase


def _file(test: str) -> str:
    """The file of a test."""
    return test.partition("::")[0]


def statement(mutant: Mutant) -> range:
    """The lines of the innermost statement that holds a mutant; of a compound one, its head."""
    lines = range(mutant.line, mutant.line + 1)
    for node in ast.walk(ast.parse((ROOT / mutant.module).read_text())):
        if isinstance(node, ast.stmt) and node.lineno <= mutant.line <= (node.end_lineno or 0):
            # The walk goes from the outside in, so that the last one found is the innermost.
            body = getattr(node, "body", None)
            end = body[0].lineno if body else (node.end_lineno or node.lineno) + 1
            if mutant.line < end:
                lines = range(node.lineno, end)
    return lines


def unmutated(kernels: bool, tests: tuple[str, ...]) -> Unmutated:
    """What tests do without a mutant; run once, in the repository itself, and kept."""
    with _ONE_AT_A_TIME[kernels, tests]:
        return _unmutated(kernels, tests)


def kept_unmutated(kernels: bool, tests: tuple[str, ...]) -> Path | None:
    """Where `--keep` keeps what these tests do without a mutant."""
    asked = source_state(f"{kernels} {tests} {_rooms_state()} {_tests_state(tests)}")
    return None if KEPT is None else KEPT / f"{asked}.pickle"


@cache
def _tests_state(tests: tuple[str, ...]) -> str:
    """What tells files of tests, as they are, from others."""
    places = [ROOT / test for test in tests]
    files = {file for place in places for file in ([place], place.rglob("*.py"))[place.is_dir()]}
    return source_state("".join(code_of(path.read_text()) for path in sorted(files)))


@cache
def _rooms_state() -> str:
    """What tells all modules of the rooms, as they are, from others: their lines are counted."""
    paths = sorted(path for room in ROOMS for path in _modules(room))
    return source_state("".join(path.read_text() for path in paths))


@cache
def _unmutated(kernels: bool, tests: tuple[str, ...]) -> Unmutated:
    path = kept_unmutated(kernels, tests)
    if path is not None and path.exists():
        found: Unmutated = pickle.loads(path.read_bytes())
        return found
    seconds: dict[str, float] = {}
    failed: list[str] = []
    executed: dict[str, dict[int, list[str]]] = {}
    # Where kernels are Python, one file may take an hour: then the others do.
    for number, group in enumerate([(test,) for test in tests] if kernels else [tests], start=1):
        try:
            report, lines = _covered(kernels, group, LONGEST / number if kernels else None)
        except subprocess.TimeoutExpired:
            print(f"left out, as it takes long without compilation: {group[0]}", file=sys.stderr)
            continue
        failed += failures(report)
        for module, own in lines.items():
            for line, contexts in own.items():
                executed.setdefault(module, {}).setdefault(line, []).extend(contexts)
        for taken, name in re.findall(
            r"^([\d.]+)s (?:setup|call|teardown) +(\S.*)$", report, re.MULTILINE
        ):
            seconds[name] = seconds.get(name, 0.0) + float(taken)
    for name in failed:
        print(f"left out, as it fails without any mutant: {name}", file=sys.stderr)
    found = Unmutated(seconds, tuple(failed), executed)
    if path is not None:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(pickle.dumps(found))
    return found


def _covered(
    kernels: bool, tests: tuple[str, ...], limit: float | None
) -> tuple[str, dict[str, dict[int, list[str]]]]:
    """What pytest reports, and the tests that execute each line, by modules."""
    from coverage import CoverageData

    coverage = ("--cov=avsec_gym", "--cov-context=test", "--cov-report=")
    durations = ("--durations=0", "--durations-min=0.005", "-rfE", "--tb=no")
    command = pytest_of(*coverage, *durations, *tests)
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder, "coverage"))
        done = ran(command, ROOT, kernels, limit, more={"COVERAGE_FILE": file})
        if done.returncode not in PASSED and not failures(done.stdout):
            report = done.stdout[-2000:] + done.stderr[-2000:]
            raise SystemExit(
                f"{' '.join(tests)} end with {done.returncode} without a mutant:\n{report}"
            )
        data = CoverageData(file)
        data.read()
        return done.stdout, {
            str(Path(path).relative_to(ROOT)): data.contexts_by_lineno(path)
            for path in data.measured_files()
        }


def failures(report: str) -> tuple[str, ...]:
    """The tests that pytest's short summary names as failed, as `--deselect` takes them.

    Example:
        >>> failures("FAILED tests/a.py::test_b[x - y] - assert 1 == 2\\n1 failed in 0.1s")
        ('tests/a.py::test_b[x - y]',)
    """
    lines = re.findall(r"^(?:FAILED|ERROR) (\S+?::[^\[\s]+(?:\[.*?\](?= - |$))?)", report, re.M)
    return tuple(dict.fromkeys(lines))


def pytest_of(*words: str) -> list[str]:
    """The command that runs fast tests in one process."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-m", "not slow"]
    # Where kernels are Python, hashes overflow as they shall, and numpy warns of it.
    command += ["-W", "ignore:overflow encountered:RuntimeWarning", "-p", "no:cacheprovider"]
    return [*command, *words]


def ran(
    command: Sequence[str],
    copy: Path,
    kernels: bool,
    limit: float | None = None,
    more: Mapping[str, str] = MappingProxyType({}),
) -> subprocess.CompletedProcess[str]:
    """A command in the copy; kernels run as plain Python where `kernels` is True."""
    environment = os.environ | {
        **more,
        "PYTHONPATH": str(copy),
        "OMP_NUM_THREADS": "1",
        "PYTHONDONTWRITEBYTECODE": "1",
        "NUMBA_DISABLE_JIT": str(int(kernels)),
    }
    return subprocess.run(
        command, cwd=copy, env=environment, capture_output=True, text=True, timeout=limit
    )


def tried(mutant: Mutant, copy: Path) -> dict[str, Any]:
    """What becomes of a mutant, with the change itself."""
    import cosmic_ray.plugins as plugins
    from cosmic_ray.mutating import mutate_code

    path = copy / mutant.module
    before = path.read_text()
    kernels = "@kernel(" in before
    begun = time.monotonic()
    after = mutate_code(before, plugins.get_operator(mutant.operator)(), mutant.occurrence)
    change = [
        line
        for line in difflib.unified_diff(before.splitlines(), after.splitlines(), lineterm="", n=0)
        if line[:1] in "+-" and line[:3] not in ("+++", "---")
    ]
    try:
        path.write_text(after)
        by = killed_by(copy, kernels, mutant)
    finally:
        path.write_text(before)
    return asdict(mutant) | {
        "source": source_state(code_of(before)),
        "change": change,
        "killed_by": by,
        "seconds": round(time.monotonic() - begun, 1),
    }


def source_state(source: str) -> str:
    """What tells a text from another."""
    return hashlib.sha256(source.encode()).hexdigest()[:16]


def tried_in_one_of(copies: SimpleQueue[Path], mutant: Mutant) -> dict[str, Any]:
    """Try a mutant in a copy that no other uses."""
    copy = copies.get()
    try:
        return tried(mutant, copy)
    finally:
        copies.put(copy)


def copied_repository(folder: Path, number: int) -> Path:
    """The tracked files, and a link to the data beside the repository."""
    folder = folder / str(number)
    copy = folder / "repository"
    names = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True).stdout
    for name in names.splitlines():
        source = ROOT / name
        if source.exists():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, copy / name, follow_symlinks=False)
    if (ROOT.parent / "shared").exists():
        (folder / "shared").symlink_to(ROOT.parent / "shared")
    return copy


def main() -> None:
    """Try a sample, print how many the tests killed and which ones they did not."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="+", default=list(ROOMS), help="rooms of the package")
    parser.add_argument("--jobs", type=int, default=1, help="mutants at once, each in a copy")
    parser.add_argument("--keep", type=Path, help="lines of JSON; goes on with what is there")
    options = parser.parse_args()
    global KEPT
    if options.keep:
        KEPT = options.keep.with_suffix(".unmutated")
    known = options.keep.read_text().splitlines() if options.keep and options.keep.exists() else []
    rows = {json.dumps(_key(row)): row for row in map(json.loads, known) if holds(row)}
    sample = list(islice(all_mutants(options.only, options.seed), options.count))
    columns = ("{task.description}", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    left = [mutant for mutant in sample if json.dumps(_key(asdict(mutant))) not in rows]
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(options.jobs) as pool:
        copies: SimpleQueue[Path] = SimpleQueue()
        for number in range(options.jobs):
            copies.put(copied_repository(Path(folder), number))
        found = pool.map(lambda mutant: tried_in_one_of(copies, mutant), left)
        with Progress(*columns, transient=True) as progress:
            for row in progress.track(found, total=len(left), description="mutants"):
                rows[json.dumps(_key(row))] = row
                if options.keep:
                    with options.keep.open("a") as file:
                        file.write(json.dumps(row) + "\n")
    chosen = [rows[json.dumps(_key(asdict(mutant)))] for mutant in sample]
    survivors = [row for row in chosen if not row["killed_by"]]
    result = {
        "mutants": len(chosen),
        "killed": len(chosen) - len(survivors),
        "share": round(1 - len(survivors) / len(chosen), 3),
        "survivors": survivors,
    }
    print(json.dumps(result, indent=1))


def holds(row: dict[str, Any]) -> bool:
    """Whether a mutant was killed, and the code of its module is still as it was then."""
    path = ROOT / row["module"]
    return (
        bool(row["killed_by"])
        and path.exists()
        and row.get("source") == source_state(code_of(path.read_text()))
    )


def _key(row: dict[str, Any]) -> list[Any]:
    return [row["module"], row["operator"], row["occurrence"]]


if __name__ == "__main__":
    main()
