"""The command line: `avsec COMMAND`; `avsec COMMAND --help` tells units and defaults.

Exit codes: 0 done, 1 bad data, 2 bad usage, 3 done in part (something was skipped and reported).
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Sequence
from typing import Annotated

import tyro

from avsec_gym import __version__
from avsec_gym.commands import console
from avsec_gym.commands.attack import AttackPatch
from avsec_gym.commands.average_precision import ScoreDetections
from avsec_gym.commands.data import DataCheck
from avsec_gym.commands.demo import Demo
from avsec_gym.commands.detect import Detect
from avsec_gym.commands.draw import Draw
from avsec_gym.commands.evaluate import Evaluate
from avsec_gym.commands.experiments import Experiments
from avsec_gym.commands.plan import PlanFiles
from avsec_gym.commands.report import Report
from avsec_gym.commands.run import Run
from avsec_gym.commands.train import Train
from avsec_gym.commands.validate import Validate
from avsec_gym.commands.weights import Weights
from avsec_gym.commands.world import World
from avsec_gym.errors import AvsecError, ConfigurationError

Command = (
    Annotated[Demo, tyro.conf.subcommand("demo")]
    | Annotated[Evaluate, tyro.conf.subcommand("evaluate")]
    | Annotated[Detect, tyro.conf.subcommand("detect")]
    | Annotated[ScoreDetections, tyro.conf.subcommand("ap")]
    | Annotated[AttackPatch, tyro.conf.subcommand("attack")]
    | Annotated[Validate, tyro.conf.subcommand("validate")]
    | Annotated[Experiments, tyro.conf.subcommand("experiments")]
    | Annotated[Run, tyro.conf.subcommand("run")]
    | Annotated[Report, tyro.conf.subcommand("report")]
    | Annotated[PlanFiles, tyro.conf.subcommand("plan")]
    | Annotated[Draw, tyro.conf.subcommand("draw")]
    | Annotated[DataCheck, tyro.conf.subcommand("data")]
    | Annotated[World, tyro.conf.subcommand("world")]
    | Annotated[Train, tyro.conf.subcommand("train")]
    | Annotated[Weights, tyro.conf.subcommand("weights")]
)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command and leave with its exit code."""
    sys.exit(run(sys.argv[1:] if arguments is None else arguments))


def run(arguments: Sequence[str]) -> int:
    """Run a command.

    Args:
        arguments: As on the command line, without the program's name.

    Returns:
        The exit code.
    """
    logging.basicConfig(format="avsec: %(message)s", level=logging.WARNING)
    arguments = list(arguments) or ["--help"]
    if arguments == ["--version"]:
        sys.stdout.write(f"avsec {__version__}\n")
        return console.DONE
    if arguments[:2] in (["data", "check"], ["attack", "patch"]):
        # These have one verb so far; the subcommand stands for both words.
        arguments = [arguments[0], *arguments[2:]]
    try:
        command = tyro.cli(
            Command,
            prog="avsec",
            description="Does a self-driving car still drive safely under attack?",
            args=arguments,
            config=(tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff),
        )
        return command.run()
    except ConfigurationError as error:
        console.complain(error)
        return console.BAD_USAGE
    except AvsecError as error:
        console.complain(error)
        return console.BAD_DATA
    except BrokenPipeError:
        return console.DONE
    except OSError as error:
        # Places that cannot be read or written; the message of the system names them.
        console.say(f"avsec: {error}. Check the path, its permissions and the free space.")
        return console.BAD_DATA
    except KeyboardInterrupt:
        console.say("avsec: stopped")
        return 130
