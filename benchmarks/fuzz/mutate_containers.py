"""What happens to files with an inner order: databases, zip archives, PNGs, safetensors.

These changes keep checksums and lengths right where a byte's change would break them, so that they
reach what reads the content.
"""

from __future__ import annotations

import io
import json
import sqlite3
import struct
import tempfile
import zipfile
import zlib
from pathlib import Path
from random import Random
from typing import Any

from mutate_bytes import BYTES, Mutator

_CELLS: tuple[Any, ...] = (
    None, -1, 0, 2**62, 1e300, float("inf"), float("-inf"), "", "x", "nan", "[1", "{}", "[]",
    "[" * 100_000, b"\xff\xfe", b"", "\x00", "done", "x" * 100_000, "1e400",
)  # fmt: skip


def cell(content: bytes, random: Random) -> bytes:
    """A value in a table becomes one of another type, past every constraint."""

    def change(database: sqlite3.Connection) -> None:
        database.execute("PRAGMA ignore_check_constraints = ON")
        database.execute("PRAGMA foreign_keys = OFF")
        table = random.choice(_tables(database))
        columns = [row[1] for row in database.execute(f"PRAGMA table_info('{table}')")]
        column = random.choice(columns)
        rows = random.choice(("1", "rowid = (SELECT max(rowid) FROM {0})")).format(f"'{table}'")
        value = random.choice(_CELLS)
        try:
            database.execute(f"UPDATE OR IGNORE '{table}' SET {column} = ? WHERE {rows}", [value])
        except sqlite3.Error:
            database.execute(f"DELETE FROM '{table}'")

    return _changed(content, change)


def undecodable(content: bytes, random: Random) -> bytes:
    """Text that is none in UTF-8."""

    def change(database: sqlite3.Connection) -> None:
        database.execute("PRAGMA ignore_check_constraints = ON")
        table = random.choice(_tables(database))
        columns = [row[1] for row in database.execute(f"PRAGMA table_info('{table}')")]
        column = random.choice(columns)
        try:
            database.execute(
                f"UPDATE OR IGNORE '{table}' SET {column} = CAST(x'fffe31' AS TEXT)"
                f" WHERE rowid = (SELECT min(rowid) FROM '{table}')"
            )
        except sqlite3.Error:
            database.execute("PRAGMA user_version = 99")

    return _changed(content, change)


def table(content: bytes, random: Random) -> bytes:
    """A table is missing, empty, renamed, has another column, or is a view that never ends."""

    def change(database: sqlite3.Connection) -> None:
        database.execute("PRAGMA foreign_keys = OFF")
        name = random.choice(_tables(database))
        column = database.execute(f"PRAGMA table_info('{name}')").fetchall()[-1][1]
        statement = random.choice(
            (
                f"DROP TABLE '{name}'",
                f"DELETE FROM '{name}'",
                f"ALTER TABLE '{name}' RENAME TO other",
                f"ALTER TABLE '{name}' RENAME COLUMN {column} TO other",
                f"ALTER TABLE '{name}' ADD COLUMN other",
                f"DROP TABLE '{name}'; CREATE VIEW '{name}' AS WITH RECURSIVE n(cell) AS"
                " (SELECT 1 UNION ALL SELECT cell + 1 FROM n) SELECT * FROM n",
                "PRAGMA user_version = 0",
                "PRAGMA user_version = 77",
                f"CREATE TRIGGER t AFTER INSERT ON '{name}' BEGIN DELETE FROM '{name}'; END",
                "CREATE TABLE surplus (x)",
            )
        )
        try:
            database.executescript(statement)
        except sqlite3.Error:
            database.execute("PRAGMA user_version = 3")

    return _changed(content, change)


def page(content: bytes, random: Random) -> bytes:
    """A page of the database is zero, or stands where another one stood."""
    size = 4096
    pages = max(1, len(content) // size)
    one, other = random.randrange(pages), random.randrange(pages)
    filler = random.choice((b"\0" * size, content[other * size : (other + 1) * size]))
    return content[: one * size] + filler + content[(one + 1) * size :]


SQLITE: dict[str, Mutator] = {
    f"sqlite_{mutator.__name__}": mutator for mutator in (cell, undecodable, table, page)
}


def member(content: bytes, random: Random) -> bytes:
    """A member of a zip archive is changed, missing, doubled, renamed or of 300 MB."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = [(name, archive.read(name)) for name in archive.namelist()]
    except zipfile.BadZipFile:
        return content
    at = random.randrange(len(members))
    name, data = members[at]
    match random.randrange(7):
        case 0:
            mutate = random.choice(list(BYTES.values()))
            members[at] = (name, mutate(data, random))
        case 1:
            del members[at]
        case 2:
            members[at] = (random.choice(("x", "../x", "/x", name + "x", "")), data)
        case 3:
            members[at] = (name, b"\0" * 300_000_000)
        case 4:
            members[at] = (name, b"")
        case 5:
            members.append((name + "2", data))
        case 6:
            other = random.randrange(len(members))
            members[at] = (name, members[other][1])
    target = io.BytesIO()
    method = random.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA))
    if any(len(data) > 10_000_000 for _, data in members):
        method = zipfile.ZIP_DEFLATED
    with zipfile.ZipFile(target, "w", method) as archive:
        for name, data in members:
            archive.writestr(name or "empty", data)
    return target.getvalue()


def array_header(content: bytes, random: Random) -> bytes:
    """The header of an array in a ``.npz`` promises another shape or type."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
    except zipfile.BadZipFile:
        return content
    name = random.choice(list(members))
    data = members[name]
    if not data.startswith(b"\x93NUMPY"):
        return content
    length = struct.unpack("<H", data[8:10])[0]
    header = random.choice(
        (
            "{'descr': '<f4', 'fortran_order': False, 'shape': (4000000000,), }",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (-1, 4), }",
            "{'descr': '<f4', 'fortran_order': True, 'shape': (2, 4), }",
            "{'descr': '|O', 'fortran_order': False, 'shape': (3,), }",
            "{'descr': '<c16', 'fortran_order': False, 'shape': (1,), }",
            "{'descr': '<U4', 'fortran_order': False, 'shape': (2,), }",
            "{'descr': '<M8[ns]', 'fortran_order': False, 'shape': (3,), }",
            "{'descr': [('a', '<f4'), ('b', '<f4')], 'fortran_order': False, 'shape': (3,), }",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (), }",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (0, 4), }",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 1, 1, 1, 4), }",
            "{'descr': '<f4', 'shape': " + "(" * 500 + ")" * 500 + "}",
            "__import__('os').system('false')",
            "{}",
        )
    )
    members[name] = (
        data[:8] + struct.pack("<H", len(header)) + header.encode() + data[10 + length :]
    )
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return target.getvalue()


def array_value(content: bytes, random: Random) -> bytes:
    """Values of an array in a ``.npz`` are not finite, huge or of another sign."""
    import numpy as np

    with np.load(io.BytesIO(content), allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}
    name = random.choice(list(arrays))
    array = arrays[name].astype(random.choice((np.float32, np.float64)))
    array.flat[random.randrange(array.size)] = random.choice(
        (np.nan, np.inf, -np.inf, 1e30, -5.0, 1e6, 0.0)
    )
    arrays[name] = random.choice((array, array[:0], array[None], array.T, array > 0))
    target = io.BytesIO()
    np.savez(target, **arrays)
    return target.getvalue()


ZIP: dict[str, Mutator] = {"zip_member": member}
NPZ: dict[str, Mutator] = {
    f"npz_{mutator.__name__}": mutator for mutator in (member, array_header, array_value)
}


def chunk(content: bytes, random: Random) -> bytes:
    """A chunk of a PNG is changed, missing, doubled or exchanged, with its checksum right."""
    chunks = _chunks(content)
    at = random.randrange(len(chunks))
    kind, data = chunks[at]
    match random.randrange(4):
        case 0:
            mutate = random.choice(list(BYTES.values()))
            chunks[at] = (kind, mutate(data, random))
        case 1:
            del chunks[at]
        case 2:
            chunks.insert(at, (kind, data))
        case 3:
            random.shuffle(chunks)
    return _png(chunks)


def header(content: bytes, random: Random) -> bytes:
    """A PNG promises another size, depth, colour type or interlacing."""
    chunks = _chunks(content)
    width, height, *rest = struct.unpack(">IIBBBBB", chunks[0][1][:13])
    match random.randrange(5):
        case 0:
            width = random.choice((0, 1, width + 1, 2**31 - 1, 60_000, 2**32 - 1))
        case 1:
            height = random.choice((0, 1, height + 1, 2**31 - 1, 60_000, 2**32 - 1))
        case 2:
            width, height = 30_000, 30_000
        case 3:
            rest[0] = random.choice((0, 1, 2, 4, 8, 16, 32))
        case 4:
            rest[random.randint(1, 4)] = random.choice((0, 1, 2, 3, 4, 6, 9))
    chunks[0] = (b"IHDR", struct.pack(">IIBBBBB", width, height, *rest))
    return _png(chunks)


def bomb(content: bytes, random: Random) -> bytes:
    """A PNG, or a text in one, that unfolds to hundreds of megabytes."""
    chunks = _chunks(content)
    zeros = zlib.compress(b"\0" * 200_000_000, 1)
    if random.random() < 0.5:
        chunks.insert(1, (b"zTXt", b"k\0\0" + zeros))
        return _png(chunks)
    side = random.choice((8_000, 14_000))
    head = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    return _png([(b"IHDR", head), (b"IDAT", zeros), (b"IEND", b"")])


def other_format(content: bytes, random: Random) -> bytes:
    """The picture in another format, or in other colours, under the same name."""
    import cv2
    import numpy as np

    image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    suffix = random.choice((".jpg", ".bmp", ".tiff", ".webp", ".ppm", ".png"))
    plain = image.astype(np.uint8) if image.dtype != np.uint8 else image
    if suffix == ".ppm" and plain.ndim == 2:
        suffix = ".png"
    if suffix == ".png":
        shape = (*plain.shape[:2], 4)
        plain = random.choice(
            (np.zeros(shape, np.uint8), plain[:1, :1], plain.astype(np.uint16) * 257, plain[::2])
        )
    return bytes(cv2.imencode(suffix, np.ascontiguousarray(plain))[1].tobytes())


PNG: dict[str, Mutator] = {
    f"png_{mutator.__name__}": mutator for mutator in (chunk, header, bomb, other_format)
}


def tensor_header(content: bytes, random: Random) -> bytes:
    """The header of safetensors promises other places, shapes or types, or is none."""
    length = struct.unpack("<Q", content[:8])[0]
    about = json.loads(content[8 : 8 + length])
    names = [name for name in about if name != "__metadata__"]
    name = random.choice(names)
    facts = about[name]
    match random.randrange(9):
        case 0:
            facts["shape"] = random.choice(
                ([], [-1], [2**40], [2**63], [0], None, ["3"], [1, 1, 1])
            )
        case 1:
            facts["dtype"] = random.choice(
                ("I8", "U8", "I64", "BOOL", "F64", "BF16", "F16", "C64", "F8_E4M3", "X", None)
            )
        case 2:
            facts["data_offsets"] = random.choice(([0, 0], [-4, 4], [0, 2**62], [8, 0], None))
        case 3:
            about[random.choice(("other", "", "x" * 9_000))] = about.pop(name)
        case 4:
            del about[name]
        case 5:
            about["__metadata__"] = random.choice((None, {"a": 1}, {"a": "b" * 100_000}, []))
        case 6:
            return struct.pack("<Q", random.choice((0, 2**63, 2**40, length + 7))) + content[8:]
        case 7:
            return content[:8] + b"[" * length + content[8 + length :]
        case 8:
            del facts[random.choice(list(facts))]
    new = json.dumps(about).encode()
    return struct.pack("<Q", len(new)) + new + content[8 + length :]


def tensor_value(content: bytes, random: Random) -> bytes:
    """A tensor becomes one of another type or shape, or not finite."""
    import torch
    from safetensors.torch import load, save

    tensors = load(content)
    name = random.choice(list(tensors))
    old = tensors[name]
    new = random.choice(
        (
            old.to(torch.int8), old.to(torch.bool), old.to(torch.float64), old.to(torch.bfloat16),
            old.reshape(-1), old[None], torch.full_like(old, float("nan"))
            if old.is_floating_point() else old, old.to(torch.complex64), old.reshape(-1)[:0],
            torch.full_like(old, float("inf")) if old.is_floating_point() else old - 10**6,
        )
    )  # fmt: skip
    return save({**tensors, name: new.contiguous()})


SAFETENSORS: dict[str, Mutator] = {
    f"safetensors_{mutator.__name__}": mutator for mutator in (tensor_header, tensor_value)
}


def pickled(content: bytes, random: Random) -> bytes:
    """A checkpoint with tensors of other types, other things beside them, or code."""
    import collections
    import os

    import numpy as np
    import torch

    whole = torch.load(io.BytesIO(content), weights_only=True)
    # Of a training's state, the tensors lie one floor deeper.
    inner = random.choice([value for value in whole.values() if isinstance(value, dict)] or [whole])
    state: Any = inner if len(inner) > 1 else whole
    name = random.choice([key for key in state if hasattr(state[key], "to")] or list(state))
    old = torch.as_tensor(state[name]) if isinstance(state[name], (int, float)) else state[name]
    if not isinstance(old, torch.Tensor):
        old = torch.zeros(3)

    class Code:
        def __reduce__(self) -> Any:
            return (os.getcwd, ())

    match random.randrange(12):
        case 0:
            state[name] = old.to(torch.complex64)
        case 1:
            state[name] = old.to(torch.int8)
        case 2:
            state[name] = torch.full_like(old.float(), float("nan"))
        case 3:
            state[name] = old.reshape(-1)
        case 4:
            state["epoch"] = np.float64(3.5)
        case 5:
            whole = state = {"state_dict": state, "epoch": np.float32(1), "rng": np.arange(3)}
        case 6:
            state["code"] = Code()
        case 7:
            whole = random.choice(
                ([1, 2], 5, "weights", None, {}, {"model": {"model": {}}}, (old,))
            )
        case 8:
            state[random.choice((5, None, "", ("a", 1)))] = state.pop(name)
        case 9:
            state[name] = old.to_sparse() if old.ndim else old
        case 10:
            state[name] = torch.zeros(1).expand(10**9)
        case 11:
            whole = collections.OrderedDict((f"module.module.{k}", v) for k, v in state.items())
    target = io.BytesIO()
    torch.save(whole, target, _use_new_zipfile_serialization=random.random() < 0.7)
    return target.getvalue()


CHECKPOINT: dict[str, Mutator] = {"checkpoint_content": pickled, **ZIP}


def _tables(database: sqlite3.Connection) -> list[str]:
    found = database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")
    return [row[0] for row in found if not row[0].startswith("sqlite_")]


def _changed(content: bytes, change: Any) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "changed.sqlite"
        path.write_bytes(content)
        database = sqlite3.connect(path)
        try:
            database.execute("PRAGMA journal_mode = DELETE")
            change(database)
            database.commit()
        finally:
            database.close()
        return path.read_bytes()


def _chunks(content: bytes) -> list[tuple[bytes, bytes]]:
    chunks, place = [], 8
    while place + 8 <= len(content):
        (length,) = struct.unpack(">I", content[place : place + 4])
        kind = content[place + 4 : place + 8]
        chunks.append((kind, content[place + 8 : place + 8 + length]))
        place += 12 + length
    return chunks


def _png(chunks: list[tuple[bytes, bytes]]) -> bytes:
    """A PNG of chunks, each with its length and checksum."""
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )
