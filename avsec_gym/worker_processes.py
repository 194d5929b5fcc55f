"""Processes that work for this one, and that never read the script which the user runs.

`multiprocessing` has every new process import its parent's main module: a script without a
``__main__`` guard begins anew in each worker, standard input cannot be imported at all, and the
processes of vector environments, which are daemons, may start none.  A worker here is a Python
that imports the modules of what it is sent, and nothing else.  All processes that this package
starts are started here.
"""

from __future__ import annotations

import io
import os
import pickle
import select
import signal
import subprocess
import sys
import threading
import traceback
from collections.abc import Callable, Collection, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from itertools import islice
from multiprocessing.connection import Connection, Pipe, wait
from pathlib import Path
from typing import Any, TypeVar

from avsec_gym import registry
from avsec_gym.errors import ConfigurationError, DataError

THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
"""Libraries read them when they are loaded."""

AVAILABLE = sys.platform != "win32"
"""Whether there are such processes here."""

_SECONDS_TO_LEAVE = 5.0
_SECONDS_BETWEEN_LOOKS = 1.0
# The search path comes first, so that whatever this process can import the worker can, too.
_PROGRAM = """
import signal, sys
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    signal.signal(number, signal.SIG_IGN)
from multiprocessing.connection import Connection
connection = Connection(int(sys.argv[1]))
sys.path[:] = connection.recv()
from avsec_gym.worker_processes import _work
_work(connection, int(sys.argv[2]))
"""

Task = TypeVar("Task")
Result = TypeVar("Result")


class Worker:
    """A process that serves this one, until it is ended or this one is gone, whatever ends it.

    Ctrl-C is left to this process, and so are the signals that ask a group of processes to end.

    Args:
        serve: What it does: a function of a module, that takes the worker's end of the connection
            and the arguments, and returns when the connection is closed (EOFError).
        arguments: The arguments of `serve`; objects of modules, too.
        threads: The number of threads of the libraries that it loads.

    Raises:
        ConfigurationError: Something to be sent belongs to the main script, or the system has no
            such processes.
    """

    def __init__(self, serve: Callable[..., None], *arguments: Any, threads: int) -> None:
        if not AVAILABLE:
            raise ConfigurationError("several processes need Linux or macOS: use one worker")
        first = _pickled((_registrations(), serve, arguments))
        self._connection, theirs = Pipe()
        variables = dict.fromkeys(THREAD_VARIABLES, str(threads))
        flags = [f"-W{option}" for option in sys.warnoptions]
        # -P: no module beside the user's script, or in his folder, goes before Python's own.
        program = [sys.executable, "-P", *flags, "-c", _PROGRAM]
        with _interrupts_held_back():
            self._process = subprocess.Popen(
                [*program, str(theirs.fileno()), str(os.getpid())],
                # The worker reads nothing from it: its end shows that this process is gone.
                stdin=subprocess.PIPE,
                pass_fds=[theirs.fileno()],
                env=os.environ | variables,
            )
        theirs.close()
        with suppress(OSError):  # It has died already; `receive` will show it.
            self._connection.send(sys.path)
            self._connection.send_bytes(first)

    def send(self, message: Any) -> None:
        """Send something; if the worker has died, `receive` will show it.

        Raises:
            ConfigurationError: It belongs to the main script.
        """
        with suppress(OSError):
            self._connection.send_bytes(_pickled(message))

    def receive(self) -> Any:
        """What the worker sends next; waits for it.

        Raises:
            EOFError: The worker has died; `how_it_ended` describes how.
            ConfigurationError: It could not import what it was sent.
        """
        try:
            while not self.said_something(_SECONDS_BETWEEN_LOOKS):
                if self.has_left():
                    raise EOFError
            message = self._connection.recv()
        except OSError as error:
            raise EOFError from error
        if isinstance(message, _NotImported):
            raise ConfigurationError(
                f"a worker process cannot import what it should do: {message.error}. Is it in a "
                "module on the search path? One worker, which is this very process, needs no import"
            )
        return message

    def said_something(self, seconds: float = 0.0) -> bool:
        """Whether there is something to receive, within some seconds; the end counts, too."""
        return self._connection.poll(seconds)

    def has_left(self) -> bool:
        """Whether it is gone, and nothing that it sent is left."""
        return self._process.poll() is not None and not self.said_something()

    def how_it_ended(self) -> str:
        """Such as ``was killed by signal 9 (Killed)``; of one that is dying, or else is killed."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(_SECONDS_TO_LEAVE)
        self.dismiss(at_once=True)
        self.join()
        code = self._process.returncode
        if code < 0:
            return f"was killed by signal {-code} ({signal.strsignal(-code)})"
        return f"left with exit code {code}"

    def dismiss(self, *, at_once: bool) -> None:
        """Let it go: when it has done what it has in hand, or whatever it has in hand."""
        self._connection.close()
        if at_once:
            self._process.kill()

    def join(self) -> None:
        """Wait until one that was dismissed is gone, but not for long."""
        try:
            self._process.wait(_SECONDS_TO_LEAVE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        assert self._process.stdin is not None, "it is a pipe"
        self._process.stdin.close()


def wait_for(workers: Collection[Worker]) -> list[Worker]:
    """The workers, of some, that have sent something or died; waits until there is one."""
    while True:
        ready = wait([worker._connection for worker in workers], _SECONDS_BETWEEN_LOOKS)
        # A process that the worker has forked may hold its end open: so we look for it, too.
        found = [each for each in workers if each._connection in ready or each.has_left()]
        if found:
            return found


def each_in_processes(
    prepare: Callable[[], Callable[[Task], Result]],
    tasks: Iterable[Task],
    workers: int,
    *,
    threads: int,
    folder: Path,
) -> Generator[tuple[Task, Result], None, None]:
    """Do tasks in processes; yields each with its result as they are finished.

    Closing the generator ends the processes at once.

    Args:
        prepare: Function that makes the function that does a task, once in each worker.
        tasks: What to do; taken as workers become free.
        workers: How many processes at most.
        threads: The number of threads of each.
        folder: What the workers write into, which the error of a death names.

    Raises:
        DataError: A worker died.
        ConfigurationError: See `Worker`.
        Exception: What `prepare` or the function raised, with a note that states where.
    """
    waiting = iter(tasks)
    team: list[Worker] = []
    in_hand: dict[Worker, Task] = {}

    def hand_out(worker: Worker, task: Task) -> None:
        worker.send(task)
        in_hand[worker] = task

    try:
        for task in islice(waiting, workers):
            team.append(Worker(_do_tasks, prepare, threads=threads))
            hand_out(team[-1], task)
        while in_hand:
            for worker in wait_for(in_hand):
                result, task = _result(worker, folder), in_hand.pop(worker)
                # Before the result is looked at, so that the worker does not wait for that.
                for following in islice(waiting, 1):
                    hand_out(worker, following)
                yield task, result
    finally:
        for worker in team:
            worker.dismiss(at_once=worker in in_hand)
        for worker in team:
            worker.join()


def _result(worker: Worker, folder: Path) -> Any:
    try:
        answer = worker.receive()
    except EOFError:
        raise DataError(
            f"A worker process {worker.how_it_ended()} before its work was done.",
            path=folder,
            remedy="Was it killed, or is the memory full? Fewer workers take less; begin again to "
            "go on.",
        ) from None
    if isinstance(answer, _Raised):
        answer.error.add_note(f"In a worker process:\n{answer.trace}")
        raise answer.error
    return answer


@dataclass(frozen=True)
class _NotImported:
    error: str


@dataclass(frozen=True)
class _Raised:
    error: Exception
    trace: str


def _work(connection: Connection, parent: int) -> None:
    """A worker's life; processes that it starts do not keep its connection."""
    os.set_inheritable(connection.fileno(), False)
    threading.Thread(target=_leave_with_parent, args=(parent,), daemon=True).start()
    try:
        registrations, serve, arguments = connection.recv()
    except Exception as error:
        connection.send(_NotImported(f"{type(error).__name__}: {error}"))
        return
    registry.adopt(registrations)
    serve(connection, *arguments)


def _leave_with_parent(parent: int) -> None:
    # Processes that the parent has forked may hold the pipe open: so we look for it, too.
    while os.getppid() == parent:
        if select.select([0], [], [], _SECONDS_BETWEEN_LOOKS)[0]:
            break
    os._exit(1)


def _do_tasks(connection: Connection, prepare: Callable[[], Callable[[Any], Any]]) -> None:
    function: Callable[[Any], Any] | None = None
    while True:
        try:
            task = connection.recv()
        except (EOFError, OSError):
            return
        try:
            function = function or prepare()
            answer = function(task)
        except Exception as error:
            answer = _Raised(_portable(error), traceback.format_exc())
        connection.send(answer)


def _portable(error: Exception) -> Exception:
    """The error itself, if it survives the way to another process."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error


class _Pickler(pickle.Pickler):
    def reducer_override(self, obj: Any) -> Any:
        """Refuses what only this process can import."""
        if getattr(obj, "__module__", None) == "__main__" and hasattr(obj, "__qualname__"):
            raise ConfigurationError(
                f"worker processes do not read the main script, and {obj.__qualname__} is defined "
                "there: put it into a module of its own and import it, or use one worker"
            )
        return NotImplemented


def _pickled(what: Any) -> bytes:
    buffer = io.BytesIO()
    try:
        _Pickler(buffer).dump(what)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        raise ConfigurationError(
            f"this cannot be sent to worker processes: {error}. Use one worker"
        ) from error
    return buffer.getvalue()


def _registrations() -> dict[tuple[registry.Kind, str], Callable[..., Any]]:
    """What was registered by hand; without what is of the main script, which raises if used."""
    found = registry.registered_by_hand()
    for (kind, name), factory in found.items():
        try:
            _pickled(factory)
        except ConfigurationError as error:
            found[kind, name] = partial(registry.refuse, kind, name, str(error))
    return found


@contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """A process begins with the signal mask of the thread that starts it.

    So Ctrl-C, and what asks for an end, cannot hit a worker before it knows to ignore it.
    """
    before = signal.pthread_sigmask(
        signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}
    )
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
