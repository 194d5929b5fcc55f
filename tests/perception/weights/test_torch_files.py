"""Files of torch.save, read without torch, give what torch reads; damaged ones give one error."""

from __future__ import annotations

import collections
import io
import random
import zipfile
from pathlib import Path
from typing import Any

import pytest
import torch

from avsec_gym.errors import DataError
from avsec_gym.perception.weights.torch_files import read_torch_file

KINDS = (
    torch.float64, torch.float32, torch.float16, torch.bfloat16, torch.int64, torch.int32,
    torch.int16, torch.int8, torch.uint8, torch.bool, torch.complex64,
)  # fmt: skip


def content() -> dict[str, Any]:
    base = torch.arange(12.0).reshape(3, 4)
    parameter = torch.nn.Parameter(torch.ones(3))
    optimizer = torch.optim.Adam([parameter])
    parameter.grad = torch.ones(3)
    optimizer.step()
    return {
        "model": collections.OrderedDict(a=base, turned=base.t(), part=base[1:, ::2], p=parameter),
        "kinds": {str(kind): torch.tensor([0, 1, 1]).to(kind) for kind in KINDS},
        "odd shapes": [torch.tensor(3), torch.zeros(0, 3), torch.zeros(2, 0)],
        "plain": [1, -70000, 2**40, 2.5, None, True, "text", b"bytes", (1, 2, 3, 4), {1: {2: []}}],
        "optimizer": optimizer.state_dict(),
    }


def same(one: Any, two: Any) -> bool:
    if isinstance(one, torch.Tensor):
        return one.dtype == two.dtype and torch.equal(one, two)
    if isinstance(one, dict):
        return list(one) == list(two) and all(same(one[name], two[name]) for name in one)
    if isinstance(one, (list, tuple)):
        return len(one) == len(two) and all(map(same, one, two))
    return bool(one == two)


@pytest.mark.parametrize("archive", [True, False])
def test_reads_what_torch_reads(tmp_path: Path, archive: bool) -> None:
    path = tmp_path / "file.pth"
    torch.save(content(), path, _use_new_zipfile_serialization=archive)
    found = read_torch_file(path, remedy="")
    assert same(torch.load(path, weights_only=True), found)
    assert not same(torch.zeros(3), torch.zeros(3, dtype=torch.float64)), "the judge judges"


@pytest.mark.parametrize("archive", [True, False])
def test_damage_is_one_error(tmp_path: Path, archive: bool) -> None:
    buffer = io.BytesIO()
    torch.save(content(), buffer, _use_new_zipfile_serialization=archive)
    sound, path = buffer.getvalue(), tmp_path / "file.pth"
    randomness, refused = random.Random(int(archive)), 0
    for _ in range(300):
        damaged = mutated(bytearray(sound), randomness)
        path.write_bytes(damaged)
        error = refusal(path)
        refused += error is not None
        assert error is None or (error.path == str(path) and "weights_only" not in str(error))
    assert refused > 200


def refusal(path: Path) -> DataError | None:
    try:
        read_torch_file(path, remedy="Again.")
    except DataError as error:
        return error
    return None


def mutated(content: bytearray, randomness: random.Random) -> bytes:
    """Cut off, changed, shortened or lengthened somewhere."""
    place, length = randomness.randrange(len(content)), randomness.randrange(1, 30)
    match randomness.randrange(4):
        case 0:
            del content[place:]
        case 1:
            for _ in range(randomness.choice([1, 1, 2, 8])):
                content[randomness.randrange(len(content))] = randomness.randrange(256)
        case 2:
            del content[place : place + length]
        case _:
            content[place:place] = content[:length]
    return bytes(content)


@pytest.mark.parametrize("text", [b"", b"P", b"not a checkpoint", b"\x80\x02.", b"PK\x05\x06"])
def test_other_files_are_one_error(tmp_path: Path, text: bytes) -> None:
    path = tmp_path / "file.pth"
    path.write_bytes(text)
    with pytest.raises(DataError, match=r"sound file of torch.save|archive is damaged"):
        read_torch_file(path, remedy="")


def test_tensors_stay_within_their_numbers(tmp_path: Path) -> None:
    """A pickle that promises more numbers than there are would read the memory behind them."""
    path = tmp_path / "file.pth"
    torch.save({"a": torch.zeros(2, 3)}, path)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    pickled = next(name for name in members if name.endswith("data.pkl"))
    # BININT1 2, BININT1 3: the size; and BININT1 6: how many numbers the storage has.
    for before, after in ((b"K\x02K\x03", b"K\x02K\x04"), (b"K\x06", b"K\x07")):
        assert before in members[pickled]
        with zipfile.ZipFile(path, "w") as archive:
            for name, bytes_ in members.items():
                changed = bytes_.replace(before, after) if name == pickled else bytes_
                archive.writestr(name, changed)
        with pytest.raises(DataError, match=r"does not fit|numbers have"):
            read_torch_file(path, remedy="")


def test_deep_and_circular_values_end(tmp_path: Path) -> None:
    path = tmp_path / "file.pth"
    nested = b"\x80\x02" + b"(" * 50_000 + b"t" * 50_000
    for pickled in (
        nested + b"}\x94h\x00K\x01s.",
        nested + b".",
        b"\x80\x02}q\x00X\x05\0\0\0modelh\x00s.",
    ):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("archive/data.pkl", pickled)
        error = refusal(path)
        assert error is None or "sound" in str(error)
