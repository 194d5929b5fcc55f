"""Names in records are those of every process, whatever its locale."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from avsec_gym.storage.portable_names import local, portable

NAME = "größe-日本"
KEPT = NAME.encode().decode("ascii", "surrogateescape")
"""As Python has it where the locale knows ASCII alone."""


def test_bytes_of_utf8_are_spelled() -> None:
    record = {KEPT: [KEPT, 1, None, {"deep": (KEPT, 2.5)}], "plain": "name"}
    assert portable(record) == {NAME: [NAME, 1, None, {"deep": (NAME, 2.5)}], "plain": "name"}
    assert local(record) == portable(record) == portable(portable(record))


@pytest.mark.parametrize("text", ["", "name", NAME, "no UTF-8 \udcff", "no byte \ud800"])
def test_what_spells_nothing_else_is_left(text: str) -> None:
    assert portable(text) == local(text) == text


def test_a_process_of_ascii_opens_what_a_record_names() -> None:
    script = (
        "import os, sys; from avsec_gym.storage.portable_names import local, portable;"
        "assert sys.getfilesystemencoding() == 'ascii';"
        "kept = sys.argv[1]; assert not kept.isascii(); assert portable(kept) != kept;"
        "assert local(portable(kept)) == kept == local(kept);"
        "sys.stdout.buffer.write(portable(kept).encode())"
    )
    plain = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = subprocess.run(
        [sys.executable, "-c", script, NAME],
        env=os.environ | plain | {"PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        check=True,
    )
    assert done.stdout.decode() == NAME
