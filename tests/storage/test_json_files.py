from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from avsec_gym.storage.json_files import DEEPEST, parse_json, read_json, read_json_object

BAD = {
    "nothing": "",
    "cut off": '{"a": [1, 2',
    "deep lists": "[" * 100_000,
    "deep whole lists": "[" * (DEEPEST + 1) + "]" * (DEEPEST + 1),
    "deep dictionaries": '{"a":' * 2000 + "1" + "}" * 2000,
    "infinite": "[1e999]",
    "NaN": '{"a": NaN}',
    "minus infinity": "-Infinity",
    "a long integer": "9" * 5000,
    "an integer of 65 bits": str(2**64),
}


@pytest.mark.parametrize("text", BAD.values(), ids=BAD.keys())
def test_bad_json_is_one_error(tmp_path: Path, text: str) -> None:
    with pytest.raises(ValueError, match=r"\S"):
        parse_json(text)
    path = tmp_path / "file.json"
    path.write_text(text)
    with pytest.raises(DataError, match=r"file\.json.* Write it anew\."):
        read_json(path, remedy="Write it anew.")


def test_good_json_is_what_python_reads() -> None:
    value = {"a": [1, -2.5, None, True, "ä"], "b": {"c": [[], {}]}, "d": 2**62}
    assert parse_json(json.dumps(value)) == value
    assert parse_json("[" * DEEPEST + "]" * DEEPEST) == json.loads("[" * DEEPEST + "]" * DEEPEST)
    assert math.isnan(parse_json("NaN", finite=False))


def test_an_object_is_a_dictionary(tmp_path: Path) -> None:
    path = tmp_path / "file.json"
    path.write_text('{"a": 1}')
    assert read_json_object(path, remedy="") == {"a": 1}
    path.write_text("[1]")
    with pytest.raises(DataError, match="something else"):
        read_json_object(path, remedy="")
