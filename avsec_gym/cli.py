"""The command line: `avsec COMMAND`; `avsec COMMAND --help` states units and defaults.

Exit codes: 0 done, 1 bad data, 2 bad usage, 3 done in part (something was skipped and reported);
as a shell counts signals, 130 stopped by Ctrl-C, 129 and 143 by another signal, 141 where the
reader of the output has left, as `head` does.
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from avsec_gym import __version__, console
from avsec_gym.commands.process import (
    Terminated,
    end_when_asked,
    output_is_cut_off,
    settle_output,
    stand_in_for_closed_streams,
    write_any_text,
)
from avsec_gym.errors import AvsecError, ConfigurationError
from avsec_gym.suggestions import unknown_name

_PROGRAM = "avsec"
_QUESTION = "Does a self-driving car still drive safely under attack?"
_HELP = ("-h", "--help")


@dataclass(frozen=True)
class CommandGroup:
    """Commands of one kind, as in `avsec world make`.

    Args:
        summary: One sentence.
        commands: The commands by their second word.
    """

    summary: str
    commands: Mapping[str, str]


_WORLD, _PICTURES = "avsec_gym.commands.world", "avsec_gym.commands.world_pictures"
COMMANDS: Mapping[str, str | CommandGroup] = {
    "demo": "avsec_gym.commands.demo:Demo",
    "evaluate": "avsec_gym.commands.evaluate:Evaluate",
    "detect": "avsec_gym.commands.detect:Detect",
    "ap": "avsec_gym.commands.average_precision:ScoreDetections",
    "disparity": "avsec_gym.commands.disparity:ScoreDisparities",
    "attack": CommandGroup(
        "Attacks that are trained.", {"patch": "avsec_gym.commands.attack:AttackPatch"}
    ),
    "validate": "avsec_gym.commands.validate:Validate",
    "connected": "avsec_gym.commands.connected:Connected",
    "experiments": "avsec_gym.commands.experiments:Experiments",
    "run": "avsec_gym.commands.run:Run",
    "report": "avsec_gym.commands.report:Report",
    "benchmark": CommandGroup(
        "The frozen benchmark: enter a part of your own, and see all entries side by side.",
        {
            "detector": "avsec_gym.commands.benchmark:BenchmarkDetector",
            "attack": "avsec_gym.commands.benchmark:BenchmarkAttack",
            "validator": "avsec_gym.commands.benchmark:BenchmarkValidator",
            "planner": "avsec_gym.commands.benchmark:BenchmarkPlanner",
            "frames": "avsec_gym.commands.benchmark:BenchmarkFrames",
            "board": "avsec_gym.commands.benchmark:BenchmarkBoard",
        },
    ),
    "plan": "avsec_gym.commands.plan:PlanFiles",
    "drive": "avsec_gym.commands.drive:DriveInTraffic",
    "draw": "avsec_gym.commands.draw:Draw",
    "data": CommandGroup(
        "What is in a data folder.", {"check": "avsec_gym.commands.data:DataCheck"}
    ),
    "world": CommandGroup(
        "Procedural data sets in KITTI's layouts, and digital twins of real frames.",
        {
            "make": f"{_WORLD}:WorldMake",
            "twin": f"{_WORLD}:WorldTwin",
            "verify": f"{_WORLD}:WorldVerify",
            "sheet": f"{_PICTURES}:WorldSheet",
            "show": f"{_PICTURES}:WorldShow",
        },
    ),
    "train": "avsec_gym.commands.train:Train",
    "agents": CommandGroup(
        "Agents that play the environments, beside searched baselines.",
        {
            "train": "avsec_gym.commands.agents:AgentsTrain",
            "evaluate": "avsec_gym.commands.agents:AgentsEvaluate",
            "list": "avsec_gym.commands.agents:AgentsList",
        },
    ),
    "hub": CommandGroup(
        "Agents and weights in the layout of the Hugging Face hub.",
        {
            "export": "avsec_gym.commands.hub:HubExport",
            "import": "avsec_gym.commands.hub:HubImport",
        },
    ),
    "error-model": CommandGroup(
        "What a detector gets wrong, for drives without images.",
        {
            "fit": "avsec_gym.commands.error_model:ErrorModelFit",
            "check": "avsec_gym.commands.error_model:ErrorModelCheck",
        },
    ),
    "weights": CommandGroup(
        "Weights of networks: published ones, and the scores of detectors.",
        {
            "import": "avsec_gym.commands.weights:WeightsImport",
            "calibrate": "avsec_gym.commands.weights_calibrate:WeightsCalibrate",
        },
    ),
}
"""Where each command is, ``"module:class"``: only the one that is asked for is imported."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command and leave with its exit code."""
    stand_in_for_closed_streams()
    end_when_asked()
    write_any_text()
    sys.exit(run(sys.argv[1:] if arguments is None else arguments))


def run(arguments: Sequence[str]) -> int:
    """Run a command.

    Args:
        arguments: The words as on the command line, without the program's name.

    Returns:
        The exit code.
    """
    logging.basicConfig(format="avsec: %(message)s", level=logging.WARNING)
    try:
        return _run_and_explain(arguments)
    except BrokenPipeError:
        # The reader has left, perhaps while an error was being explained: an end without a word.
        settle_output()
        return console.CUT_OFF


def every_command() -> dict[str, Any]:
    """The class of each command by its words, such as ``world make``: imports them all."""
    every: dict[str, Any] = {}
    for name, found in COMMANDS.items():
        there = {name: found} if isinstance(found, str) else _in_full(name, found)
        every |= {words: _class(place) for words, place in there.items()}
    return every


def _run_and_explain(arguments: Sequence[str]) -> int:
    """Run a command; where it cannot be done, write why.

    Raises:
        BrokenPipeError: The reader of the output has left.
    """
    try:
        code = _run(arguments)
        # What a full disk or a closed pipe does to buffered output shows only here.
        sys.stdout.flush()
        return code
    except ConfigurationError as error:
        console.complain(error)
        return console.BAD_USAGE
    except AvsecError as error:
        console.complain(error)
        return console.BAD_DATA
    except OSError as error:
        if isinstance(error, BrokenPipeError) and output_is_cut_off():
            raise
        settle_output()
        # Places that cannot be read or written; the message of the system names them.
        console.say(f"avsec: {error}. Check the path, its permissions and the free space.")
        return console.BAD_DATA
    except Terminated as signal:
        console.say("avsec: stopped")
        return 128 + signal.number
    except KeyboardInterrupt:
        console.say("avsec: stopped")
        return 130


def _run(arguments: Sequence[str]) -> int:
    """Find the command by the first word, or by two, and run it.

    Raises:
        ConfigurationError: There is no such command; the message names what it may have meant.
    """
    program, summary, there, words = _PROGRAM, _QUESTION, COMMANDS, list(arguments)
    if words == ["--version"]:
        console.print_line(f"avsec {__version__}")
        return console.DONE
    while True:
        if not words or words[0] in _HELP:
            console.print_line(_overview(program, summary, there))
            # A group's name alone is no command; the program's alone asks what there is.
            return console.DONE if words or program == _PROGRAM else console.BAD_USAGE
        name = words.pop(0)
        if name not in there:
            problem = f"{program} has no command {name}"
            raise ConfigurationError(unknown_name(problem, name, there))
        found, program = there[name], f"{program} {name}"
        if isinstance(found, str):
            break
        summary, there = found.summary, found.commands
    # Imported here: tyro takes its time, and the overview needs none of it.
    from avsec_gym.commands.arguments import parse

    try:
        command = parse(_class(found), words, program)
    except SystemExit as end:  # The help was asked for, or tyro has refused a word.
        return int(end.code or 0)
    code: int = command.run()
    return code


def _in_full(name: str, group: CommandGroup) -> dict[str, str]:
    return {f"{name} {word}": place for word, place in group.commands.items()}


def _class(place: str) -> Any:
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)


def _overview(program: str, summary: str, there: Mapping[str, str | CommandGroup]) -> str:
    """A line for each command."""
    width = max(map(len, there))
    lines = [f"  {name:{width}}  {_summary(found)}" for name, found in there.items()]
    return "\n".join(
        [
            f"usage: {program} COMMAND [OPTIONS]",
            "",
            summary,
            "",
            *lines,
            "",
            f"`{program} COMMAND --help` describes a command, its options and defaults.",
        ]
    )


def _summary(found: str | CommandGroup) -> str:
    """What a command does, or which there are in a group."""
    if isinstance(found, CommandGroup):
        return f"{found.summary[:-1]}: {', '.join(found.commands)}"
    first, _, _ = _class(found).__doc__.partition("\n")
    return str(first)
