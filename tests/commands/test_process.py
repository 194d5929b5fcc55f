"""Commands whose standard streams are closed, full or gone: no traceback."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from avsec_gym import cli
from avsec_gym.boxes import Boxes3D
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.commonroad import write_commonroad

CALL = f"{sys.executable} -c 'from avsec_gym.cli import main; main()'"


@pytest.mark.skipif(sys.platform == "win32", reason="needs a POSIX shell")
@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&-", ">&- 2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize(("words", "code"), [("agents list", 0), ("--version", 0), ("nothing", 2)])
def test_closed_streams(closed: str, words: str, code: int, tmp_path: Path) -> None:
    out = tmp_path / "out.txt"
    command = f"{{ {CALL} {words} {closed}; }} > {out} 2>&1"
    done = subprocess.run(["sh", "-c", command], timeout=120)
    assert done.returncode == code
    assert "Traceback" not in out.read_text()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("words", ["agents list", "--version", ""])
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_output(words: str, unbuffered: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    done = subprocess.run(
        ["sh", "-c", f"{CALL} {words} > /dev/full"], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 1
    assert done.stderr.startswith("avsec: ")
    assert "Traceback" not in done.stderr


def ends_without_a_reader(words: list[str], unread: str, tmp_path: Path) -> tuple[int, str]:
    """The exit code, and what is on the streams that are read; nothing reads ``unread``."""
    read, write = os.pipe()
    os.close(read)
    with open(tmp_path / "read.txt", "w+", encoding="utf-8") as file:
        streams = {"stdout": file, "stderr": file} | dict.fromkeys(unread.split(), write)
        call = [sys.executable, "-m", "avsec_gym", *words]
        done = subprocess.run(call, timeout=120, **streams)
        os.close(write)
        file.seek(0)
        return done.returncode, file.read()


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("problem") / "free.xml"
    scenario = build_planning_scenario(Boxes3D.empty(), road_type=RoadType.STREET, id="free")
    write_commonroad(scenario, path)
    return path


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX pipes")
@pytest.mark.parametrize(
    ("unread", "unbuffered"),
    [
        ("stdout", ""),
        pytest.param("stdout", "1", marks=pytest.mark.slow),
        pytest.param("stdout stderr", "", marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize(
    "words",
    [
        "--version",
        "evaluate --help",
        "agents list",
        "plan {problem}",
        "plan {problem} {problem}",
        "evaluate --scenarios layouts --limit 1 --json",
    ],
)
def test_a_reader_who_leaves_ends_a_command_as_sigpipe_would(
    words: str,
    unread: str,
    unbuffered: str,
    problem: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A line, a help, a table, a row at once, several, and a document: `avsec ... | head -1`."""
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    code, read = ends_without_a_reader(words.format(problem=problem).split(), unread, tmp_path)
    assert code == 141
    assert read == ""


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX pipes")
@pytest.mark.parametrize("words", ["nothing", "plan nothing.xml", "evaluate --limit 0"])
def test_a_reader_who_leaves_before_an_error_is_explained(words: str, tmp_path: Path) -> None:
    code, read = ends_without_a_reader(words.split(), "stderr", tmp_path)
    assert code == 141
    assert "Traceback" not in read


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX pipes")
def test_rows_before_the_reader_leaves_are_whole(problem: Path) -> None:
    call = [sys.executable, "-m", "avsec_gym", "plan", *[str(problem)] * 400, "--json"]
    with subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert json.loads(process.stdout.readline())["status"]
        process.stdout.close()  # More rows come than a pipe takes.
        assert process.stderr.read() == b""
        assert process.wait(timeout=120) == 141


def test_another_pipe_that_breaks_is_an_error(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def breaks(words: object) -> int:
        raise BrokenPipeError(32, "Broken pipe", "worker")

    monkeypatch.setattr(cli, "_run", breaks)
    assert cli.run(["evaluate"]) == 1
    assert "Broken pipe: 'worker'" in capfd.readouterr().err


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


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are UTF-8 there")
@pytest.mark.parametrize("encoding", ["utf-8:strict", "ascii"])
def test_a_name_that_is_no_utf_8_is_written_plainly(encoding: str, tmp_path: Path) -> None:
    """A table of such files ended in a UnicodeEncodeError."""
    name = os.fsdecode(bytes(tmp_path / "made_elsewhere_") + b"\xff.xml")
    Path(name).write_text("<commonRoad/>", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", "from avsec_gym.cli import main; main()", "plan", name],
        capture_output=True,
        env=os.environ | {"PYTHONIOENCODING": encoding},
        timeout=120,
    )
    written = (done.stdout + done.stderr).decode("ascii" if encoding == "ascii" else "utf-8")
    assert done.returncode == 1
    assert "Traceback" not in written
    assert r"\udcff.xml" in done.stdout.decode(errors="replace")
