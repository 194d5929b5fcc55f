"""Processes that never read the main script, and what happens when a process dies."""

from __future__ import annotations

import ast
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import avsec_gym
from avsec_gym import registry
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.worker_processes import THREAD_VARIABLES, Worker, each_in_processes, wait_for

TIMEOUT = 120
"""Seconds after which a program counts as hanging."""
TASKS = '''
import os, signal, sys, time

from avsec_gym.errors import DataError
from avsec_gym.registry import make


def doubling():
    return lambda number: (2 * number, os.getpid())


def ending(how):
    def end(number):
        if how == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        if how == "forked":  # A process of its own holds its end of the connection open.
            if os.fork() == 0:
                time.sleep(60)
                os._exit(0)
            os.kill(os.getpid(), signal.SIGKILL)
        if how == "left":
            sys.exit(7)
        if how == "odd":
            raise Odd(1, 2)
        raise DataError("There is a hole in it.", path="bucket")

    return end


class Odd(Exception):
    """Does not survive pickling."""

    def __init__(self, one, two):
        super().__init__(f"{one}{two}")


def sleeping(diary):
    def sleep(number):
        with open(diary, "a") as file:
            file.write(f"{os.getpid()}\\n")
        time.sleep(number)

    return sleep


def variables():
    return lambda name: os.environ.get(name)


def making():
    return lambda name: make("detector", name)


def factory():
    return "made by hand"


def echo(connection):
    while True:
        try:
            connection.send(connection.recv())
        except EOFError:
            return


class NotThere:
    """Pickled by a name that its module has not."""


NotThere.__qualname__ = "Nowhere.Either"
'''


@pytest.fixture
def tasks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """Functions in a module that workers can import."""
    (tmp_path / "worker_tasks.py").write_text(TASKS)
    monkeypatch.syspath_prepend(tmp_path)
    import worker_tasks

    yield worker_tasks
    del sys.modules["worker_tasks"]


def each(prepare: Callable[[], Any], asked: Any, workers: int = 2) -> dict[Any, Any]:
    folder = Path("of-the-workers")
    return dict(each_in_processes(prepare, asked, workers, threads=1, folder=folder))


def gone(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except FileNotFoundError:
        return True


def soon(condition: Callable[[], bool], seconds: float = 10.0) -> bool:
    deadline = time.monotonic() + seconds
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.02)
    return condition()


@pytest.mark.slow
def test_tasks_are_done_in_other_processes_and_each_once(tasks: ModuleType) -> None:
    found = each(tasks.doubling, range(20), workers=3)
    assert {task: result for task, (result, _) in found.items()} == {n: 2 * n for n in range(20)}
    processes = {process for _, process in found.values()}
    assert 1 <= len(processes) <= 3
    assert os.getpid() not in processes
    assert all(map(gone, processes))
    assert each(tasks.doubling, []) == {}


@pytest.mark.slow
def test_threads_are_told_to_the_libraries_of_the_worker_only(
    tasks: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(THREAD_VARIABLES[0], "7")
    assert each(tasks.variables, THREAD_VARIABLES) == dict.fromkeys(THREAD_VARIABLES, "1")
    assert os.environ[THREAD_VARIABLES[0]] == "7"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("killed", r"^of-the-workers: .*was killed by signal 9 \(Killed\) .*Fewer workers"),
        ("forked", r"was killed by signal 9"),
        ("left", r"left with exit code 7"),
        ("raised", r"^bucket: There is a hole in it\.\nIn a worker"),
    ],
)
def test_a_death_and_an_error_are_told(tasks: ModuleType, how: str, said: str) -> None:
    with pytest.raises(DataError, match=said) as raised:
        each(partial(tasks.ending, how), [1, 2, 3])
    if how == "raised":
        assert "In a worker process:\nTraceback" in raised.value.__notes__[0]
        assert 'worker_tasks.py", line' in raised.value.__notes__[0]


def test_an_error_that_cannot_travel_is_told_in_words(tasks: ModuleType) -> None:
    with pytest.raises(RuntimeError, match=r"^Odd: 12\n"):
        each(partial(tasks.ending, "odd"), [1])


@pytest.mark.slow
def test_closing_ends_workers_at_once(tasks: ModuleType, tmp_path: Path) -> None:
    diary = tmp_path / "diary"
    sleeping = partial(tasks.sleeping, str(diary))
    working = each_in_processes(sleeping, [0.0, 500.0], 2, threads=1, folder=tmp_path)
    assert next(working)[0] == 0.0
    assert soon(lambda: len(diary.read_text().splitlines()) == 2)
    begun = time.monotonic()
    working.close()
    assert time.monotonic() - begun < 5.0
    assert all(gone(int(line)) for line in diary.read_text().splitlines())


@pytest.mark.slow
def test_one_can_wait_for_those_who_say_something(tasks: ModuleType) -> None:
    one, two = (Worker(tasks.echo, threads=1) for _ in range(2))
    try:
        two.send("hello")
        assert wait_for([one, two]) == [two]
        assert two.receive() == "hello"
        assert not one.said_something()
    finally:
        for worker in (one, two):
            worker.dismiss(at_once=False)
            worker.join()
    assert one.how_it_ended() == "left with exit code 0"


def test_what_the_worker_cannot_import_is_told(tasks: ModuleType) -> None:
    with pytest.raises(ConfigurationError, match="cannot be sent to worker processes"):
        Worker(tasks.echo, lambda: 1, threads=1)
    source = Path(tasks.__file__ or "")
    source.write_text(TASKS.replace("def doubling", "def tripling"))
    os.utime(source, (0, 0))  # Compiled code of the same second and size would be taken for it.
    with pytest.raises(ConfigurationError, match=r"cannot import .*doubling.*One worker"):
        each(tasks.doubling, [1])


def test_what_was_registered_by_hand_is_known_to_workers(
    tasks: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(registry, "_REGISTERED", {})
    registry.register("detector", "mine", tasks.factory)
    registry.register("detector", "local", lambda: 1)
    assert each(tasks.making, ["mine"]) == {"mine": "made by hand"}
    with pytest.raises(ConfigurationError, match=r"'local' is not known here: .*cannot be sent"):
        each(tasks.making, ["local"])


# A second run of the program, by whoever reads it, is a second line in the diary.
PROGRAM = """
import os, sys
from pathlib import Path

sys.path.insert(0, {folder!r})
import worker_tasks
from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import register
from avsec_gym.worker_processes import each_in_processes

with open({diary!r}, "a") as file:
    file.write("read\\n")

def mine(): return "mine"

register("detector", "mine", mine)
working = each_in_processes(worker_tasks.doubling, [1, 2, 3], 2, threads=1, folder=Path())
print(sorted(result for _, (result, _) in working))
for prepare, asked in ((mine, 1), (worker_tasks.making, "mine")):
    try: list(each_in_processes(prepare, [asked], 1, threads=1, folder=Path()))
    except ConfigurationError as error: print(error)

"""
WAYS = {
    "script": ["{script}"],
    "stdin": ["-"],
    "command": ["-c", "{program}"],
    "interactive": ["-i", "-q"],
    "module": ["-m", "program"],
}


@pytest.mark.parametrize("way", WAYS)
def test_no_worker_reads_the_main_script(tasks: ModuleType, tmp_path: Path, way: str) -> None:
    """However it is run; it has no guard."""
    diary, script = tmp_path / "diary", tmp_path / "program.py"
    program = PROGRAM.format(folder=str(tmp_path), diary=str(diary))
    script.write_text(program)
    words = [word.format(script=script, program=program) for word in WAYS[way]]
    done = subprocess.run(
        [sys.executable, *words],
        input=program,
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    assert "[2, 4, 6]" in done.stdout.splitlines(), done.stderr
    assert "worker processes do not read the main script, and mine is defined" in done.stdout
    assert "the detector 'mine' is not known here: worker processes do not read" in done.stdout
    assert diary.read_text() == "read\n"


def _in_a_daemon(answers: Any) -> None:
    import worker_tasks

    answers.send(sorted(each(worker_tasks.doubling, [1, 2])))


@pytest.mark.slow
def test_a_daemon_may_have_workers(tasks: ModuleType) -> None:
    """As the processes of vector environments are; multiprocessing itself forbids it."""
    ours, theirs = multiprocessing.Pipe()
    context = multiprocessing.get_context("fork")
    process = context.Process(target=_in_a_daemon, args=(theirs,), daemon=True)
    process.start()
    try:
        assert ours.poll(TIMEOUT)
        assert ours.recv() == [1, 2]
    finally:
        process.kill()
        process.join()


LONG = """
import os, sys, time
from functools import partial
from pathlib import Path

sys.path.insert(0, {folder!r})
import worker_tasks
from avsec_gym.worker_processes import each_in_processes

sleeping = partial(worker_tasks.sleeping, {diary!r})
working = each_in_processes(sleeping, [0, 500, 500], 2, threads=1, folder=Path())
next(working)
if {forks} and os.fork() == 0:
    with open({diary!r}, "a") as file:
        file.write(f"{{os.getpid()}}\\n")
    time.sleep(60)
    os._exit(0)
next(working)
"""


def at_work(tmp_path: Path, forks: bool = False) -> tuple[subprocess.Popen[str], list[int]]:
    """A program in a group of its own, and the processes that work for it, or come of it."""
    diary = tmp_path / "diary"
    diary.touch()
    program = LONG.format(folder=str(tmp_path), diary=str(diary), forks=forks)
    command = [sys.executable, "-c", program]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, process_group=0)
    assert soon(lambda: len(diary.read_text().splitlines()) == 3 + forks, TIMEOUT)
    return process, list({int(line) for line in diary.read_text().splitlines()})


@pytest.mark.parametrize("forks", [False, True])
def test_workers_leave_when_their_parent_is_killed(
    tasks: ModuleType, tmp_path: Path, forks: bool
) -> None:
    """Also if another process, which the parent has forked, holds the ends of their pipes."""
    process, others = at_work(tmp_path, forks)
    process.kill()
    _, errors = process.communicate(timeout=TIMEOUT) if not forks else ("", "")
    try:
        assert soon(lambda: sum(map(gone, others)) == 2)
        assert not errors
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def test_ctrl_c_ends_the_program_and_its_workers_without_a_word_of_theirs(
    tasks: ModuleType, tmp_path: Path
) -> None:
    process, others = at_work(tmp_path)
    os.killpg(process.pid, signal.SIGINT)  # As a terminal does: to all of them.
    _, errors = process.communicate(timeout=TIMEOUT)
    assert process.returncode == -signal.SIGINT
    assert errors.count("Traceback") == 1
    assert errors.rstrip().endswith("KeyboardInterrupt")
    assert soon(lambda: all(map(gone, others)))


def test_ctrl_c_does_not_hit_a_worker_that_begins(tasks: ModuleType, tmp_path: Path) -> None:
    program = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import os, signal, worker_tasks;"
        "from avsec_gym.worker_processes import Worker;"
        "signal.signal(signal.SIGINT, signal.SIG_IGN);"
        "worker = Worker(worker_tasks.echo, threads=1);"
        "[os.killpg(0, signal.SIGINT) for _ in range(100)];"
        "worker.send('there'); print(worker.receive()); worker.dismiss(at_once=False)"
    )
    done = subprocess.run(
        [sys.executable, "-c", program.replace("signal.SIG_IGN", "lambda *_: None")],
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        process_group=0,
    )
    assert (done.stdout, done.stderr) == ("there\n", "")


STARTERS = {"multiprocessing", "concurrent.futures", "subprocess", "joblib", "loky", "pty"}
ENDS = {"Connection", "Pipe", "wait"}
"""Of pipes: these start nothing."""


def starters_in(source: str) -> set[str]:
    """What a module imports that starts processes."""
    if not any(word in source for word in ("process", "concurrent", "fork", "spawn", "os.", "pty")):
        return set()
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = {alias.name for alias in node.names}
            if node.module == "concurrent.futures":
                names -= {"ThreadPoolExecutor", "as_completed", "Future"}
            if node.module == "multiprocessing.connection":
                names -= ENDS
            found |= {f"{node.module}.{name}" for name in names}
        elif isinstance(node, ast.Attribute) and node.attr in ("fork", "forkpty", "posix_spawn"):
            found.add(f"os.{node.attr}")
    return {
        name
        for name in found
        if (
            name.startswith("os.")
            and name.rpartition(".")[2] in ("fork", "forkpty", "posix_spawn", "system", "popen")
        )
        or any(name == starter or name.startswith(f"{starter}.") for starter in STARTERS)
    }


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("import multiprocessing", {"multiprocessing"}),
        ("from multiprocessing import get_context", {"multiprocessing.get_context"}),
        ("from multiprocessing.connection import Connection", set()),
        ("from concurrent.futures import ThreadPoolExecutor", set()),
        (
            "def f():\n from concurrent.futures import ProcessPoolExecutor",
            {"concurrent.futures.ProcessPoolExecutor"},
        ),
        ("import os; os.fork()", {"os.fork"}),
    ],
)
def test_what_starts_processes_is_seen(source: str, found: set[str]) -> None:
    assert starters_in(source) == found


def test_one_module_starts_all_processes() -> None:
    """Whoever needs others takes it, so that nothing of the package reads the user's script."""
    package = Path(avsec_gym.__file__).parent
    found = {
        str(path.relative_to(package)): starters
        for path in package.rglob("*.py")
        if (starters := starters_in(path.read_text()))
    }
    assert found.pop("worker_processes.py") == {"subprocess"}
    assert found == {}
