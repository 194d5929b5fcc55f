"""What people read of every command: its help, and what it answers to a slip of the pen."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
import pytest
import tyro

from avsec_gym.agents.agent_folder import shipped_agents
from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import COMMANDS, CommandGroup, every_command, run
from avsec_gym.closed_loop.error_model.model import ErrorModel, write_error_model
from avsec_gym.closed_loop.error_model.shipped import shipped_error_models
from avsec_gym.commands.arguments import Option, options
from avsec_gym.kitti.calibration import write_calibration
from avsec_gym.kitti.labels import write_detections
from avsec_gym.kitti.sensor_files import write_image
from avsec_gym.perception.weights.given import names_of_shipped_weights, shipped_weights
from avsec_gym.registry import Kind, names
from avsec_gym.rig import kitti_rig
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.commonroad import write_commonroad
from avsec_gym.storage.folder_lock import folder_lock

EVERY = every_command()
GROUPS = [name for name, found in COMMANDS.items() if isinstance(found, CommandGroup)]
SAYS_NO = re.compile(r"(Do not|Without|\w+ (no|not|nothing))\b")
"""How the text of an option begins that switches something off."""


def ends(words: list[str]) -> int:
    """The exit code, also where the argument parser ends the program itself."""
    try:
        return run(words)
    except SystemExit as end:
        return int(end.code or 0)


@pytest.fixture
def there(tmp_path: Path) -> dict[str, object]:
    """Places that commands read, by the name of what they hold; ``out`` is none yet."""
    labels = tmp_path / "labels" / "training" / "label_2"
    for id in ("000001", "000002"):
        write_detections(labels / f"{id}.txt", Boxes3D.empty())
    problem = build_planning_scenario(Boxes3D.empty(), road_type=RoadType.STREET, id="free")
    write_commonroad(problem, tmp_path / "free.xml")
    write_error_model(tmp_path / "errors.json", ErrorModel())
    whole = tmp_path / "whole" / "training"
    write_detections(whole / "label_2" / "000001.txt", Boxes3D.empty())
    write_calibration(whole / "calib" / "000001.txt", kitti_rig().calibration)
    for camera in (2, 3):
        write_image(whole / f"image_{camera}" / "000001.png", np.zeros((375, 1242, 3), np.uint8))
    return {
        "model": tmp_path / "errors.json",
        "labels": labels,
        "kitti": tmp_path / "labels",
        "whole": tmp_path / "whole",
        "out": tmp_path / "out",
        "problem": tmp_path / "free.xml",
        "weights": shipped_weights("pixor_small"),
    }


@pytest.fixture(autouse=True)
def a_page_of_one_width(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")


def texts(help: str) -> dict[str, str]:
    """The text of each argument in a rendered help, by its flag or metavar."""
    found: dict[str, str] = {}
    name = ""
    for line in help.splitlines():
        # With a frame or without one, as the encoding allows.
        if re.match(r"[│ ] (--?\w|\{|[A-Z]{2})", line):
            # What is typed, and after two blanks or on the next lines what it does.
            entry, _, text = line[2:].removeprefix("-h, ").strip("│ ").partition("  ")
            name = entry.split()[0]
            found[name] = text.strip()
        elif (more := re.match(r"[│ ] {3,}(\S.*?)[│ ]*$", line)) and name:
            found[name] = f"{found[name]} {more[1]}".strip()
        else:
            name = ""
    return found


def required(command: Any) -> list[str]:
    """Words for what a command cannot do without: places that are not there, first choices."""
    hints = get_type_hints(command, include_extras=True)
    words: list[str] = []
    for field in fields(command):
        if field.default is not MISSING or field.default_factory is not MISSING:
            continue
        hint = hints[field.name]
        plain, *marks = (hint,) if get_origin(hint) is Literal else get_args(hint) or (hint,)
        value = "dsgn" if field.name == "detector" else "missing.xml"
        value = next(iter(get_args(plain)), value) if plain is not Path else "missing"
        own = [] if tyro.conf.Positional in marks else [f"--{field.name}"]
        words += [*own, str(value)]
    return words


def shown(command: str, capsys: pytest.CaptureFixture[str], words: str = "--help") -> str:
    assert ends([*command.split(), words]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("command", EVERY)
def test_the_help_tells_every_option_and_what_can_be_typed(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    help = shown(command, capsys)
    assert help.startswith(f"usage: avsec {command} ")
    # Neither None nor what Python calls an option that may be left out.
    assert not re.search(
        r"\{None|None[,}]|[A-Z}]\||\|[A-Z{]|\(default: (None|True|False)?\)", help
    ), help
    found = texts(help)
    flags = {option.flag for option in options(EVERY[command])}
    assert {name for name in found if name.startswith("--")} == flags | {"--help"}
    for name, text in found.items():
        said = re.sub(r"\((required|default: .*)\)$", "", text).strip()
        assert len(said) > 4, f"{name} has no text: {text!r}"
        assert "None" not in said, f"{name}: None cannot be typed: {said}"


@pytest.mark.parametrize("command", EVERY)
def test_the_text_of_an_option_fits_its_flag(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, text in texts(shown(command, capsys)).items():
        if name.startswith("--no-"):
            assert SAYS_NO.match(text), f"{name} reads the wrong way round: {text}"


def test_options_to_switch_something_off_are_looked_at() -> None:
    """So that the rule above is about something."""
    off = {o.flag for command in EVERY.values() for o in options(command) if "--no-" in o.flag}
    assert {"--no-locate", "--no-evidence", "--no-lidar"} <= off


def test_the_overviews_name_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    for words in ([], ["--help"], ["-h"]):
        assert ends(words) == 0
        overview = capsys.readouterr().out
        for name in COMMANDS:
            assert re.search(rf"^  {name} +\S", overview, re.MULTILINE), name
    for name in GROUPS:
        overview = shown(name, capsys)
        for command in EVERY:
            if command.startswith(f"{name} "):
                assert re.search(rf"^  {command.split()[1]} +\S", overview, re.MULTILINE), command
        assert ends([name]) == 2
        capsys.readouterr()


def slips(word: str) -> Iterator[str]:
    """Two letters exchanged, one left out, one twice, one too many."""
    middle = len(word) // 2
    yield word[: middle - 1] + word[middle] + word[middle - 1] + word[middle + 1 :]
    yield word[:middle] + word[middle + 1 :]
    yield word[:middle] + word[middle] + word[middle:]
    yield word + "x"


@pytest.mark.parametrize("command", [*COMMANDS, *(name for name in EVERY if " " in name)])
def test_a_mistyped_command_is_suggested(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    *group, word = command.split()
    known = {name.split()[-1] for name in EVERY if name.split()[:-1] == group} | set(COMMANDS)
    for slip in slips(word):
        if slip in known:
            continue
        assert ends([*group, slip]) == 2
        error = capsys.readouterr().err
        assert len(error.splitlines()) == 1
        if len(word) > 2:  # Of two letters, one is too much to lose.
            assert f'Did you mean "{word}"?' in error


@pytest.mark.parametrize("command", EVERY)
def test_a_mistyped_option_is_suggested(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    flags = [option.flag for option in options(EVERY[command])]
    for flag in flags:
        for slip in slips(flag[2:]) if len(flag) > 4 else ():
            typed = f"--{slip}"
            if typed in flags or typed == "--help":
                continue
            assert ends([*command.split(), typed, "x"]) == 2
            error = capsys.readouterr().err
            assert len(error.splitlines()) == 1, "whatever else is missing"
            assert re.search(r'Did you mean "--[a-z-]+"\?', error), (flag, error)
            assert f"`avsec {command} --help`" in error
    # Among several that are near, the nearest.
    longest = max(flags, key=len)
    assert ends([*command.split(), f"{longest}x=1"]) == 2
    assert f'Did you mean "{longest}"?' in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "option"),
    [
        (name, option)
        for name, command in EVERY.items()
        for option in options(command)
        if option.choices
    ],
    ids=lambda value: getattr(value, "flag", value),
)
def test_a_mistyped_choice_is_suggested(
    command: str, option: Option, capsys: pytest.CaptureFixture[str]
) -> None:
    for choice in option.choices:
        slip = f"{choice}x"
        words = [*command.split(), *required(EVERY[command]), option.flag, slip]
        assert ends(words) == 2
        error = capsys.readouterr().err
        assert f"{option.flag} cannot be {slip}." in error
        assert f'Did you mean "{choice}"?' in error


DETECTORS = (Kind.DETECTOR, Kind.IMAGE_DETECTOR)
ATTACKS = (Kind.ATTACK, Kind.OPTICAL_ATTACK)
PARTS: dict[str, tuple[str, tuple[Kind, ...]]] = {
    "evaluate --planner": ("--scenarios layouts", (Kind.PLANNER,)),
    "detect --detector": ("--kitti {kitti} --out {out}", DETECTORS),
    "detect --attack": ("--detector oracle --kitti {kitti} --out {out}", ATTACKS),
    "attack patch --detector": ("--kitti {kitti} --out {out}", (Kind.DETECTOR,)),
    "validate --validator": ("--kitti {kitti} --out {out}", (Kind.VALIDATOR,)),
    "validate --attack": ("--kitti {kitti} --out {out}", (Kind.OPTICAL_ATTACK,)),
    "connected --attack": ("--out {out}", (Kind.CONNECTED_ATTACK,)),
    "run --detector": ("pipeline --scenarios {kitti} --out {out}", (Kind.DETECTOR,)),
    "run --attack": ("pipeline --scenarios {kitti} --out {out}", ATTACKS),
    "run --planner": ("pipeline --scenarios {kitti} --out {out}", (Kind.PLANNER,)),
    "run --validator": ("pipeline --scenarios {kitti} --out {out}", (Kind.VALIDATOR,)),
    "plan --planner": ("{problem}", (Kind.PLANNER,)),
    "drive --detector": ("--out {out}", (Kind.DETECTOR,)),
    "drive --attack": ("--out {out}", ATTACKS),
    "drive --validator": ("--out {out}", (Kind.VALIDATOR,)),
    "drive --classifier": ("--out {out}", (Kind.CLASSIFIER,)),
    "drive --selector": ("--out {out}", (Kind.SELECTOR,)),
    "drive --planner": ("--out {out}", (Kind.PLANNER,)),
    "draw --planner": ("000001 --scenarios {labels}", (Kind.PLANNER,)),
}
"""By command and option that takes a part: what else makes a whole command, and of which kinds."""
NO_PARTS = {"error-model fit --detector", "error-model fit --attack"}
"""What a file is of, for whoever reads it."""


def test_every_part_that_a_command_takes_is_looked_at() -> None:
    kinds = {str(kind) for kind in Kind}
    taken = {
        f"{name} {option.flag}"
        for name, command in EVERY.items()
        for option in options(command)
        if option.flag[2:] in kinds
    }
    assert taken - NO_PARTS == set(PARTS)


@pytest.mark.parametrize("option", PARTS)
def test_a_mistyped_part_is_suggested(
    option: str,
    there: dict[str, object],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Of whichever kind, where parts of several kinds are taken."""
    command, _, flag = option.rpartition(" ")
    words, kinds = PARTS[option]
    known = [name for kind in kinds for name in names(kind)]
    for name in known:
        slip = f"{name}x"
        assert ends([*command.split(), *words.format(**there).split(), flag, slip]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert f'Did you mean "{name}"?' in line
        assert set(known) <= set(line.partition("Known: ")[2].split("; ")[0].split(", "))


PLACES: dict[str, dict[str, str]] = {
    "evaluate": {
        "--kitti": "",
        "--scenarios": "",
        "--detections": "--scenarios {labels}",
    },
    "detect": {"--kitti": "--detector oracle --out {out}"},
    "ap": {"--kitti": "--detections {labels}", "--detections": "--kitti {kitti}"},
    "disparity": {"--kitti": "", "--disparities": "--kitti {kitti}"},
    "hub import": {"": "--out {out}"},
    "attack patch": {"--kitti": "--detector dsgn --out {out}"},
    "validate": {
        "--kitti": "",
        "--kitti-raw": "",
        "--thresholds": "--kitti {labels}",
        "--likelihood": "--kitti {labels}",
    },
    "connected": {"--data": "", "--constants": "", "--model": "--method learned"},
    "experiments": {"--scenarios": "unattacked"},
    "run": {"--scenarios": "unattacked"},
    "report": {"": ""},
    "benchmark board": {"": ""},
    "hub export": {"": "--out {out}"},
    "benchmark detector": {
        "": "--out {out}",
        "--error-model": "oracle --out {out}",
        "--labels": "{labels} --out {out}",
    },
    "benchmark attack": {"--error-model": "fgsm --out {out}"},
    "plan": {"": "", "--primitives": "{problem}"},
    "drive": {"--scenarios": "--out {out}", "--error-model": "--out {out}"},
    "draw": {
        "--scenarios": "000001",
        "--kitti": "000001 --scenarios {labels}",
        "--detections": "000001 --scenarios {labels}",
    },
    "data check": {"": ""},
    "world twin": {"--kitti": "--out {out}"},
    "world verify": {"": ""},
    "world sheet": {"": ""},
    "world show": {"": ""},
    "agents train": {"--config": "GhostObject-v1 --out {out}"},
    "agents evaluate": {"": ""},
    "train": {
        "--data": "dsgn --out {out}",
        "--validation": "dsgn --out {out} --data {kitti}",
        "--start": "dsgn --out {out} --data {kitti}",
    },
    "error-model fit": {
        "--kitti": "--out {out} --detections {labels}",
        "--detections": "--out {out} --kitti {kitti}",
    },
    "error-model check": {
        "": "--kitti {kitti} --detections {labels}",
        "--kitti": "{model} --detections {labels}",
        "--detections": "{model} --kitti {kitti}",
    },
    "weights import": {
        "": "--network dsgn",
        "--pair": "{out} --network psmnet --pair {missing} {missing} {missing}",
    },
    "weights calibrate": {"": "--kitti {labels}", "--kitti": "{weights}"},
}
"""By command and option, what else makes a whole command; ``""`` is its positional argument."""
WRITTEN = {"out", "fit", "pictures", "figure", "markdown", "cache", "rrd"}
"""Fields that name what a command writes."""
NAME_OR_PLACE = {
    *("scenarios", "agents", "error_model"),
    *("model of hub export", "model of error-model check", "part of benchmark detector"),
}
"""Fields that are a name or a place, and so no paths."""


def test_every_place_that_a_command_reads_is_looked_at() -> None:
    for name, command in EVERY.items():
        hints = get_type_hints(command)
        read = {
            field.name
            for field in fields(command)
            if "Path" in str(hints[field.name])
            or not {field.name, f"{field.name} of {name}"}.isdisjoint(NAME_OR_PLACE)
        } - WRITTEN
        if name == "demo":
            read -= {"scenarios"}  # A number.
        flags = {option.flag for option in options(command)}
        asked = {f"--{field.replace('_', '-')}" for field in read}
        assert {flag if flag in flags else "" for flag in asked} == set(PLACES.get(name, {})), name


@pytest.mark.parametrize(
    ("command", "option"), [(name, option) for name, own in PLACES.items() for option in own]
)
@pytest.mark.parametrize(
    "missing",
    ["nothing_here", "deep/er/nothing_here", "nothing_here" * 30],
    ids=["", "deep", "long"],
)
def test_a_place_that_is_not_there_has_one_exit_code(
    command: str,
    option: str,
    missing: str,
    there: dict[str, object],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    there["missing"] = missing
    words = PLACES[command][option].format(**there).split()
    named = "{missing}" in PLACES[command][option]
    place = [] if named else [option, missing] if option else [missing]
    before = sorted(tmp_path.rglob("*"))
    assert ends([*command.split(), *words, *place]) == 1
    assert sorted(tmp_path.rglob("*")) == before, "nothing is made, not even a folder"
    output = capsys.readouterr()
    (line,) = output.err.splitlines()
    assert line.startswith("avsec: ")
    assert "nothing_here" in line
    # What is wrong with a path is its first fault: not what lacks beside it or in it.
    none = r"There (is no (such (file|folder)|run here)|are no weights here)"
    assert re.search(f"{none}|No file can have a name as long as this", line)


def places(command: Any) -> list[str]:
    """The flags of a command's paths; ``""`` for those without one."""
    flags = {option.flag for option in options(command)}
    hints = get_type_hints(command)
    names = [field.name for field in fields(command) if "Path" in str(hints[field.name])]
    asked = [f"--{name.replace('_', '-')}" for name in names]
    return [flag if flag in flags else "" for flag in asked]


@pytest.mark.parametrize(
    ("command", "option"), [(name, flag) for name in EVERY for flag in places(EVERY[name])]
)
@pytest.mark.parametrize("bad", ["", "a\0b"], ids=["empty", "NUL"])
def test_a_path_that_cannot_be_one_is_refused(
    command: str,
    option: str,
    bad: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """An empty one would mean the folder that one is in."""
    monkeypatch.chdir(tmp_path)
    own = [[bad]] if not option else [[option, bad], [f"{option}={bad}"]]
    for words in own:
        given = [*command.split(), *required(EVERY[command])] if option else command.split()
        assert ends([*given, *words]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.startswith(f"avsec: avsec {command} {option}".rstrip() + ": a path or value ")
    assert not list(tmp_path.iterdir())


LOCKED = {
    "evaluate": "--scenarios {labels}",
    "detect": "--detector oracle --kitti {kitti} --ids 000001",
    "attack patch": "--detector oracle --kitti {whole} --split all",
    "run": "unattacked --scenarios layouts",
    "drive": "--limit 1",
    "world make": "--suite mixed --frames 1",
    "world twin": "--kitti {whole}",
    "train": "pixor --data {kitti}",
    "agents train": "GhostObject-v1",
    "benchmark frames": "--quick",
}
"""By command that writes into a folder over time, what else makes a whole command."""
LOCKED_ELSEWHERE = {
    "validate": "tests/commands/test_validate_command.py",
    "connected": "tests/commands/test_connected_command.py",
    "demo": "it is a run",
    "benchmark detector": "it is a run",
    "benchmark attack": "it is a run",
    "benchmark validator": "it is a run",
    "benchmark planner": "it is a run",
}
WRITTEN_AT_ONCE = {
    "report", "draw", "hub export", "hub import", "weights import", "ap",
    "benchmark board", "error-model fit", "world sheet", "world show",
}  # fmt: skip
"""Whose files come in the end, each whole or not at all, and over no other."""


def test_every_folder_that_is_written_over_time_is_looked_at() -> None:
    writes = {name for name, command in EVERY.items() if "out" in get_type_hints(command)}
    assert writes == {*LOCKED, *LOCKED_ELSEWHERE} | WRITTEN_AT_ONCE


@pytest.mark.parametrize("command", LOCKED)
def test_a_folder_that_another_process_writes_is_left_to_it(
    command: str,
    there: dict[str, object],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    out = tmp_path / "out"
    out.mkdir()
    with folder_lock(out):  # Held by this very process: locks do not ask whose they are.
        words = LOCKED[command].format(**there).split()
        assert ends([*command.split(), *words, "--out", str(out)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"avsec: {out}: Another process is writing here.")
    assert not list(out.iterdir())


NEEDS_KITTI = {"evaluate --scenarios", "draw --scenarios"}
"""A file there is a list of frames, whatever it holds: beside it, --kitti states whose."""


@pytest.mark.parametrize(
    ("command", "option"), [(name, option) for name, own in PLACES.items() for option in own]
)
@pytest.mark.parametrize("kind", ["folder", "file"])
def test_a_place_of_nothing_has_the_same_exit_code(
    command: str,
    option: str,
    kind: str,
    there: dict[str, object],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Whatever is read of it: there is nothing."""
    monkeypatch.chdir(tmp_path)
    empty = tmp_path / "nothing_here"
    if kind == "folder":
        empty.mkdir()
    else:
        empty.touch()
    there["missing"] = empty
    words = PLACES[command][option].format(**there).split()
    named = "{missing}" in PLACES[command][option]
    place = [] if named else [option, str(empty)] if option else [str(empty)]
    usage = kind == "file" and f"{command} {option}" in NEEDS_KITTI
    assert ends([*command.split(), *words, *place]) == (2 if usage else 1)
    output = capsys.readouterr()
    assert "Traceback" not in output.err
    assert output.out or output.err.startswith("avsec: ")


NAMES: dict[str, tuple[str, ...]] = {
    "evaluate --scenarios": ("layouts",),
    "experiments --scenarios": ("procedural", "street", "mixed"),
    "run --scenarios": ("procedural", "street", "mixed"),
    "drive --scenarios": ("layouts", "drives"),
    "drive --error-model": tuple(shipped_error_models()),
    "draw --scenarios": ("layouts",),
    "benchmark attack --error-model": tuple(shipped_error_models()),
    "benchmark detector --error-model": tuple(shipped_error_models()),
    "benchmark detector ": tuple(names(Kind.DETECTOR)),
    "agents evaluate ": tuple(shipped_agents()),
    "hub export ": (*shipped_agents(), *names_of_shipped_weights()),
    "error-model check ": tuple(shipped_error_models()),
}
"""By command and option that takes a name or a place, names that it takes."""


def test_every_option_that_takes_a_name_or_a_place_is_asked_for_names() -> None:
    either = {each.partition(" of ")[0] for each in NAME_OR_PLACE}
    taken = {
        f"{command} {option}"
        for command, own in PLACES.items()
        for option in own
        for field in fields(EVERY[command])
        if (option or "--") == (f"--{field.name.replace('_', '-')}" if option else "--")
        and "Path" not in str(get_type_hints(EVERY[command])[field.name])
        and field.name in either
    }
    assert taken == set(NAMES)


@pytest.mark.parametrize("option", NAMES)
def test_a_slip_of_a_name_has_one_exit_code(
    option: str,
    there: dict[str, object],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Another one than a place that is not there, though a name and a place are told alike."""
    monkeypatch.chdir(tmp_path)
    command, _, flag = option.rpartition(" ")
    words = PLACES[command][flag].format(**there).split()
    for name in NAMES[option]:
        slip = f"{name[:-2]}{name[-1]}"
        assert ends([*command.split(), *words, *([flag] if flag else []), slip]) == 2, slip
        (line,) = capsys.readouterr().err.splitlines()
        assert re.search(r'Did you mean "[^"]+"\?', line)


ABSURD = 10**12
REFUSED = {
    "demo --scenarios": "",
    "evaluate --limit": "--scenarios layouts",
    "ap --resamples": "--kitti {missing} --detections {missing}",
    "disparity --resamples": "--kitti {missing}",
    "attack patch --threads": "--kitti {missing} --detector oracle --out {missing}",
    "run --threads": "unattacked --scenarios {missing} --out {missing}",
    "drive --limit": "--out {missing}",
    "world make --frames": "--suite mixed --out {missing}",
    "world make --width": "--suite mixed --out {missing}",
    "world make --previous": "--suite mixed --out {missing}",
    "world make --drive-frames": "--suite raw --out {missing}",
    "world make --vehicles": "--suite connected --out {missing}",
    "world make --cameras": "--suite mixed --out {missing}",
    "world sheet --frames": "{missing}",
    "world sheet --columns": "{missing}",
    "world sheet --width": "{missing}",
    "train --threads": "pixor --data {missing} --out {missing}",
    "agents train --seed": "GhostObject-v1 --out {missing}",
    "agents train --episodes": "GhostObject-v1 --out {missing}",
    "agents train --threads": "GhostObject-v1 --out {missing}",
    "agents evaluate --seed": "{missing}",
    "agents evaluate --episodes": "{missing}",
}
"""By command and option whose number has a greatest one, what else makes a whole command."""
BOUNDED = {
    "limit": "there are no more frames than the data has",
    "pictures": "there are no more frames than the data has",
    "looked_at": "there are no more frames than the data has",
    "seed": "any seed is as good",
    "workers": "no more are begun than there is work",
    "jobs": "no more are begun than there is work",
    "camera": "no data has such a camera",
    "cameras": "no data has such a camera",
    "sweep": "there are no more thresholds than scores",
    "steps": "trainings are stopped, and go on",
    "sequence": "there are no more instants than the data has",
    "budgets": "searches are shown with their remaining time",
    "queries": "searches are shown with their remaining time",
    "node_limit": "--time-limit ends a search",
}
"""Numbers that need no greatest one, and why."""


def test_every_number_has_a_greatest_one_or_needs_none() -> None:
    numbers = {
        f"{name} --{field.name.replace('_', '-')}": field.name
        for name, command in EVERY.items()
        for field in fields(command)
        if re.search(r"\bint\b", str(get_type_hints(command)[field.name]))
    }
    assert not set(REFUSED) - set(numbers)
    assert {number for number, field in numbers.items() if field not in BOUNDED} <= set(REFUSED)


@pytest.mark.parametrize("option", REFUSED)
def test_an_absurd_number_is_refused_at_once(
    option: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Before anything is read: neither memory nor time is spent on it."""
    monkeypatch.chdir(tmp_path)
    command, _, flag = option.rpartition(" ")
    words = REFUSED[option].format(missing="nothing_here").split()
    assert ends([*command.split(), *words, flag, str(ABSURD)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("avsec: ")
    assert list(tmp_path.iterdir()) == []
