"""The errors that users meet: few, and each states what was wrong and the remedy."""

from __future__ import annotations

from pathlib import Path

_LONGEST_PATH = 1000


class AvsecError(Exception):
    """Base of every error that this project raises on purpose."""


class DataError(AvsecError):
    """A file or folder does not hold what its format promises.

    Args:
        problem: What is wrong, in one sentence.
        path: The file or folder.
        line: Line number in the file, counted from 1.
        remedy: What the user can do about it.
    """

    def __init__(
        self,
        problem: str,
        *,
        path: str | Path | None = None,
        line: int | None = None,
        remedy: str = "",
    ) -> None:
        self.problem = problem
        self.path = None if path is None else str(path)
        self.line = line
        self.remedy = remedy
        shown = "" if path is None else _printable(str(path))
        where = "" if path is None else f"{shown}:{line}: " if line is not None else f"{shown}: "
        super().__init__(f"{where}{problem}" + (f" {remedy}" if remedy else ""))

    def __reduce__(self) -> tuple[object, ...]:
        """Survives the way back from a worker process."""
        return (_rebuild_data_error, (self.problem, self.path, self.line, self.remedy))


def _printable(path: str) -> str:
    """A path as a message can show it: no control characters, and not a screen full."""
    if not path.isprintable():
        path = "".join(
            letter if letter.isprintable() else letter.encode("unicode_escape").decode()
            for letter in path
        )
    return path if len(path) <= _LONGEST_PATH else f"{path[:100]}...{path[-100:]}"


def _rebuild_data_error(problem: str, path: str | None, line: int | None, remedy: str) -> DataError:
    return DataError(problem, path=path, line=line, remedy=remedy)


class ConfigurationError(AvsecError):
    """An argument, a name or a combination of options that cannot work."""


class PlanningError(AvsecError):
    """A planning problem that cannot be posed, such as one without a goal."""
