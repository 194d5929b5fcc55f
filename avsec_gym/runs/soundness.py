"""Is a ``results.sqlite`` what a run wrote?  Seen when it is opened, not when a table is odd.

SQLite finds pages that do not hang together and values of a wrong type, and accepts a cost of 9.1
where 7.1 was written.  So each cell has a digest of all its rows, and so has the list of needed
cells; they are counted up again here.
"""

from __future__ import annotations

import os
import sqlite3
from collections import defaultdict, deque
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import cache
from hashlib import blake2b
from pathlib import Path
from urllib.parse import quote

from avsec_gym.errors import DataError
from avsec_gym.runs.schema import ADDED, SCHEMA, VERSION, VERSIONS, schema
from avsec_gym.storage.regular_files import check_regular, is_there

MAX_RESULTS_BYTES = 2**40
_LONGEST_VALUE = 64 * 2**20
_DIGITS = 2**128
_REMEDIES = {
    "SQLITE_FULL": "Free some space and give the command again: it goes on where it was.",
    "SQLITE_IOERR": "Check the disk and its free space, then give the command again: it goes on.",
    "SQLITE_READONLY": "Check the permissions of the folder and its files.",
    "SQLITE_CANTOPEN": "Check the permissions of the folder and its files.",
    "SQLITE_ERROR": "Ask for columns of the tables; docs/runs.md lists them.",
    "SQLITE_BUSY": "Another process holds the file; wait for it.",
}
_DAMAGED = "A damaged file cannot be repaired: name another folder, or run the experiments again."


@contextmanager
def no_sqlite_errors(path: Path, what: str) -> Iterator[None]:
    """SQLite's errors over a database become those of this project.

    Args:
        path: The file of the database.
        what: What is done with it: ``read``, ``written``.

    Raises:
        DataError: With the remedy for what SQLite found; only damage asks for another folder.
    """
    try:
        yield
    except (sqlite3.Error, UnicodeDecodeError) as error:
        code = getattr(error, "sqlite_errorname", None) or ""
        remedy = next((text for name, text in _REMEDIES.items() if code.startswith(name)), None)
        raise DataError(
            f"The results cannot be {what} ({error}).", path=path, remedy=remedy or _DAMAGED
        ) from error


def check_files(path: Path) -> None:
    """Check that a database is a regular file, and so are those that SQLite keeps beside it.

    Raises:
        DataError: One is a pipe, say, which would be waited for.
    """
    for end in ("", "-wal", "-shm", "-journal"):
        beside = path.with_name(path.name + end)
        if not end or is_there(beside):
            check_regular(beside, most=MAX_RESULTS_BYTES)


def check_sound(database: sqlite3.Connection, path: Path) -> int:
    """Check a database that a run has written; a run that writes on is no harm.

    Args:
        database: The open database.
        path: The path of the file, for messages.

    Returns:
        The version of its schema.

    Raises:
        DataError: It is damaged, or of another version.
    """
    database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _LONGEST_VALUE)
    with no_sqlite_errors(path, "read"), _one_state(database):
        version = schema_version(database)
        if version == 0:
            check_not_empty(database, path)
            raise DataError(
                "This is a database of something else.",
                path=path,
                remedy="Name the folder that `avsec run` wrote with --out.",
            )
        if version not in VERSIONS:
            raise DataError(
                f"The results have schema {version}, this version reads {VERSION}.",
                path=path,
                remedy="Read them with the version that the manifest names.",
            )
        # The schema first: a damaged one decides what the other questions mean.
        if _schema(database) not in _expected(version):
            raise _damaged("its tables are not those of a run", path)
        (found,) = database.execute("PRAGMA integrity_check(1)").fetchone()
        if found != "ok":
            raise _damaged(str(found).partition("\n")[0], path)
        if database.execute("PRAGMA foreign_key_check").fetchone() is not None:
            raise _damaged("rows belong to no cell", path)
        if version >= 2:
            _check_digests(database, path)
        else:
            for table in stored_columns():  # All texts are read once, and are texts.
                deque(database.execute(f"SELECT * FROM {table}"), maxlen=0)
        if version >= 3:
            noted = database.execute("SELECT digest FROM needs_digest").fetchall()
            if noted != [(needs_digest(database),)]:
                raise _damaged("the list of cells that experiments need is not as written", path)
    return version


def checked_as_it_lies(path: Path) -> int | None:
    """Check a database without opening it as one that others may write: nothing is left beside it.

    Args:
        path: The path of the file.

    Returns:
        The version of its schema; None where a run writes to it, or was killed meanwhile, so that
        there is a log to be read with it, as SQLite does when it opens both.

    Raises:
        DataError: As of `check_sound`.
    """
    if is_written(path):
        return None
    place = f"{uri(path)}?immutable=1"
    try:
        with no_sqlite_errors(path, "read"), closing(sqlite3.connect(place, uri=True)) as database:
            return check_sound(database, path)
    except DataError:
        if is_written(path):  # A run has begun to write while it was looked at.
            return None
        raise


def is_written(path: Path) -> bool:
    """Whether a run is writing a database, or has been killed meanwhile: its log is not empty."""
    log = path.with_name(f"{path.name}-wal")
    return is_there(log) and check_regular(log, most=MAX_RESULTS_BYTES) > 0


def uri(path: Path) -> str:
    """What SQLite names a database by.

    By bytes: under a POSIX locale, a name that is no ASCII is no text.
    """
    return f"file:{quote(os.fsencode(path.resolve()))}"


def check_not_empty(database: sqlite3.Connection, path: Path) -> None:
    """Check that a run's database holds any table.

    Raises:
        DataError: It holds none, as a file of 0 bytes.
    """
    if database.execute("SELECT 1 FROM sqlite_master").fetchone() is None:
        raise gone(path)


def gone(path: Path) -> DataError:
    """The error where a run has lost its results."""
    return DataError(
        "The results of this run are gone: the file is missing or empty.",
        path=path,
        remedy="Put a copy back; or name another folder to run it again.",
    )


def schema_version(database: sqlite3.Connection) -> int:
    """The version of a database's schema; 0 of a new one."""
    return int(database.execute("PRAGMA user_version").fetchone()[0])


def digests(database: sqlite3.Connection) -> dict[str, str]:
    """The digest of every cell, of the rows that are there."""
    sums: defaultdict[str, int] = defaultdict(int)
    for table, columns in stored_columns().items():
        for row in database.execute(f"SELECT {', '.join(columns)} FROM {table}"):
            sums[row[0]] += row_digest(table, row)
    return {cell: as_text(total) for cell, total in sums.items()}


def needs_digest(database: sqlite3.Connection) -> str:
    """The digest of the list of cells that experiments need."""
    rows = database.execute("SELECT experiment, cell FROM needs")
    return as_text(sum(row_digest("needs", row) for row in rows))


def row_digest(table: str, row: tuple[object, ...]) -> int:
    """The digest of a row's stored values; those of a cell are added: order does not count."""
    content = f"{table} {row!r}".encode("utf-8", "surrogatepass")
    return int.from_bytes(blake2b(content, digest_size=16).digest())


def as_text(total: int) -> str:
    """A cell's digest as it is stored."""
    return f"{total % _DIGITS:032x}"


@cache
def stored_columns() -> dict[str, tuple[str, ...]]:
    """The columns of each table with results, the cell first; SQLite makes the others of them."""
    with closing(sqlite3.connect(":memory:")) as database:
        database.executescript(SCHEMA)
        tables = ("cells", "drives", "detections", "measurements", "timings")
        return {
            table: tuple(row[1] for row in database.execute(f"PRAGMA table_info({table})"))
            for table in tables
        }


def _check_digests(database: sqlite3.Connection, path: Path) -> None:
    noted = dict(database.execute("SELECT cell, digest FROM digests").fetchall())
    found = digests(database)
    for cell in noted.keys() | found.keys():
        if noted.get(cell) != found.get(cell):
            raise _damaged(f"rows of the cell {cell:.40} are not what was written", path)


@cache
def _expected(version: int) -> tuple[frozenset[tuple[str, ...]], ...]:
    """What the schema may be: of today, and of earlier releases with what was added since."""
    earlier, altered = SCHEMA, ""
    for (table, name), kind in ADDED.items():
        earlier = earlier.replace(f"    {name} {kind},\n", "")
        altered += f"ALTER TABLE {table} ADD COLUMN {name} {kind};"
    scripts = [schema(version), schema(version, earlier + altered)]
    if version == 1:
        scripts.append(earlier)
    found = []
    for script in scripts:
        with closing(sqlite3.connect(":memory:")) as database:
            database.executescript(script)
            found.append(_schema(database))
    return tuple(found)


def _schema(database: sqlite3.Connection) -> frozenset[tuple[str, ...]]:
    query = "SELECT type, name, tbl_name, sql FROM sqlite_master"
    return frozenset(database.execute(query).fetchall())


@contextmanager
def _one_state(database: sqlite3.Connection) -> Iterator[None]:
    """All questions are asked of one state of the file, which a run may be writing to."""
    if database.in_transaction:
        yield
        return
    database.execute("BEGIN")
    try:
        yield
    finally:
        database.rollback()


def _damaged(how: str, path: Path) -> DataError:
    return DataError(f"The results are damaged: {how}.", path=path, remedy=_DAMAGED)
