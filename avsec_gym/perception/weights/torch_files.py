"""What ``torch.save`` writes, read without torch's unpickler: nothing in the file is executed.

Both of torch's formats, the archive of today and the stream of before 1.6.  Sizes are checked
against the bytes that are there before a tensor is made of them; in an archive every checksum is.
"""

from __future__ import annotations

import io
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from avsec_gym.errors import DataError
from avsec_gym.storage.archives import Archive
from avsec_gym.storage.inert_pickle import Name, Unknown, UnsoundPickle, load_pickle
from avsec_gym.storage.regular_files import read_bytes

MAX_CHECKPOINT_BYTES = 4 * 2**30
"""The checkpoints of the original repositories have up to 0.6 gigabytes, optimizer included."""

_STREAM_MAGIC = 0x1950A86A20F9469CFC6C
_STREAM_VERSION = 1001
_DIMENSIONS = 16
_KINDS = {
    "torch.DoubleStorage": torch.float64,
    "torch.FloatStorage": torch.float32,
    "torch.HalfStorage": torch.float16,
    "torch.BFloat16Storage": torch.bfloat16,
    "torch.LongStorage": torch.int64,
    "torch.IntStorage": torch.int32,
    "torch.ShortStorage": torch.int16,
    "torch.CharStorage": torch.int8,
    "torch.ByteStorage": torch.uint8,
    "torch.BoolStorage": torch.bool,
    "torch.ComplexFloatStorage": torch.complex64,
    "torch.ComplexDoubleStorage": torch.complex128,
}


def read_torch_file(path: str | Path, *, remedy: str) -> Any:
    """The value in a file of ``torch.save``: tensors, numbers, texts, lists, dictionaries.

    Args:
        path: The file.
        remedy: What a user can do about a damaged file.

    Returns:
        The value, on the CPU; `Unknown` where the file holds something else.

    Raises:
        DataError: The file cannot be read, is cut off or damaged, or is none of torch's.
    """
    content = read_bytes(path, most=MAX_CHECKPOINT_BYTES)
    try:
        if content[:2] == b"PK":
            return _from_archive(Archive(content, path, most=len(content), remedy=remedy))
        return _from_stream(content)
    except UnsoundPickle as error:
        raise DataError(
            f"This is no sound file of torch.save ({error}).", path=path, remedy=remedy
        ) from error


def _from_archive(archive: Archive) -> Any:
    root = next((name[:-9] for name in archive.names if name.endswith("/data.pkl")), None)
    if root is None:
        raise archive.damaged("it lacks a data.pkl")
    if f"{root}/byteorder" in archive.names and archive.read(f"{root}/byteorder") != b"little":
        raise archive.damaged("its numbers are big-endian")
    storages: dict[str, Tensor] = {}

    def storage(reference: Any) -> Tensor | Unknown:
        kind, key, count = _reference(reference)
        if kind is None:
            return Unknown("storage")
        if key not in storages:
            storages[key] = _numbers(archive.read(f"{root}/data/{key}"), kind, count)
        return _of_kind(storages[key], kind)

    return load_pickle(io.BytesIO(archive.read(f"{root}/data.pkl")), _CALLS, storage)


def _from_stream(content: bytes) -> Any:
    stream = io.BytesIO(content)
    for expected in (_STREAM_MAGIC, _STREAM_VERSION):
        if load_pickle(stream, {}) != expected:
            raise UnsoundPickle("it does not begin as torch's files do")
    load_pickle(stream, {})  # About the machine that wrote it.
    start = stream.tell()
    # The numbers come last, in the order of a list of keys: a first look finds what they are.
    kinds: dict[str, tuple[torch.dtype, int]] = {}

    def noted(reference: Any) -> Unknown:
        kind, key, count = _reference(reference)
        if kind is not None:
            kinds[key] = kind, count
        return Unknown("storage")

    load_pickle(stream, {}, noted)
    keys = load_pickle(stream, {})
    if not isinstance(keys, list) or set(keys) != set(kinds):
        raise UnsoundPickle("it lists other numbers than it uses")
    storages = {}
    for key in keys:
        kind, count = kinds[key]
        if int.from_bytes(stream.read(8), "little") != count:
            raise UnsoundPickle("its numbers are cut off")
        storages[key] = _numbers(stream.read(count * kind.itemsize), kind, count)

    def storage(reference: Any) -> Tensor | Unknown:
        kind, key, _ = _reference(reference)
        return Unknown("storage") if kind is None else _of_kind(storages[key], kind)

    stream.seek(start)
    return load_pickle(stream, _CALLS, storage)


def _reference(reference: Any) -> tuple[torch.dtype | None, str, int]:
    """Kind, key and count of the numbers that a pickle refers to."""
    if not isinstance(reference, tuple) or len(reference) < 5 or reference[0] != "storage":
        raise UnsoundPickle("it refers to something else than numbers")
    _, what, key, _, count = reference[:5]
    if not (isinstance(key, str) and type(count) is int and 0 <= count < 2**40):
        raise UnsoundPickle("it refers to numbers by no key and count")
    return _KINDS.get(what.name) if isinstance(what, Name) else None, key, count


def _numbers(content: bytes, kind: torch.dtype, count: int) -> Tensor:
    if len(content) != count * kind.itemsize:
        raise UnsoundPickle(f"{count} numbers have {len(content)} bytes")
    return torch.frombuffer(bytearray(content), dtype=kind) if count else torch.empty(0, dtype=kind)


def _of_kind(numbers: Tensor, kind: torch.dtype) -> Tensor:
    if numbers.dtype != kind:
        raise UnsoundPickle("it takes the same numbers for two kinds")
    return numbers


def _tensor(numbers: Any, offset: Any, size: Any, stride: Any, *_: Any) -> Tensor | Unknown:
    """What ``torch._utils._rebuild_tensor`` makes, within the numbers that are there."""
    if not isinstance(numbers, Tensor):
        return Unknown("tensor")
    whole = (
        (offset, *size, *stride) if isinstance(size, tuple) and isinstance(stride, tuple) else ()
    )
    if not whole or len(size) != len(stride) or len(size) > _DIMENSIONS:
        raise ValueError("a tensor has a size and strides")
    if not all(type(number) is int and 0 <= number < 2**40 for number in whole):
        raise ValueError("a tensor has whole sizes and strides")
    last = offset + sum((n - 1) * step for n, step in zip(size, stride, strict=True))
    count = math.prod(size)
    if count and (last >= len(numbers) or count > len(numbers)):
        raise ValueError(f"a tensor of size {size} does not fit into {len(numbers)} numbers")
    if not count:
        return numbers[:0].reshape(size)
    return numbers.as_strided(size, stride, offset)


def _dictionary(pairs: Any = ()) -> dict[str, Any]:
    """An ordered dictionary, which torch fills afterwards and Python 2 makes of pairs."""
    if not isinstance(pairs, (list, tuple)):
        raise ValueError("a dictionary is made of pairs")
    made = {}
    for name, value in pairs:
        if not isinstance(name, str):
            raise ValueError("a dictionary of tensors has names")
        made[name] = value
    return made


def _encoded(text: Any, encoding: Any = None) -> bytes:
    """Bytes, as pickles of Python 2's protocol spell them."""
    if not isinstance(text, str) or encoding not in ("latin1", "latin-1"):
        raise ValueError("bytes are a text in Latin-1")
    return text.encode("latin-1")


_CALLS: dict[str, Callable[..., Any]] = {
    "collections.OrderedDict": _dictionary,
    "_codecs.encode": _encoded,
    "torch._utils._rebuild_tensor": _tensor,
    "torch._utils._rebuild_tensor_v2": _tensor,
    "torch._utils._rebuild_parameter": lambda data, *_: data,
    "torch._utils._rebuild_parameter_with_state": lambda data, *_: data,
    "torch.Size": tuple,
}
