"""Commands whose standard streams are closed, full or gone: no traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

CALL = f"{sys.executable} -c 'from avsec_gym.cli import main; main()'"


@pytest.mark.skipif(sys.platform == "win32", reason="needs a POSIX shell")
@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&-", ">&- 2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize(("words", "code"), [("experiments", 0), ("--version", 0), ("nothing", 2)])
def test_closed_streams(closed: str, words: str, code: int, tmp_path: Path) -> None:
    out = tmp_path / "out.txt"
    command = f"{{ {CALL} {words} {closed}; }} > {out} 2>&1"
    done = subprocess.run(["sh", "-c", command], timeout=120)
    assert done.returncode == code
    assert "Traceback" not in out.read_text()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("words", ["experiments", "--version", ""])
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_output(words: str, unbuffered: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    done = subprocess.run(
        ["sh", "-c", f"{CALL} {words} > /dev/full"], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 1
    assert done.stderr.startswith("avsec: ")
    assert "Traceback" not in done.stderr


def test_what_an_encoding_lacks_is_written_plainly(tmp_path: Path) -> None:
    program = (
        "import sys; from avsec_gym.commands.process import write_any_text; write_any_text();"
        "print('94.0 (91.8\\u201395.6), \\u22121, \\u2014, \\u00fc, ' + sys.argv[1])"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, "ß"],
        capture_output=True,
        timeout=120,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
    )
    assert done.stdout.strip() == rb"94.0 (91.8-95.6), -1, -, \xfc, \xdf", done.stderr
