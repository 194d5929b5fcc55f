"""Words on the command line become a dataclass, and its fields a help that reads well."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Annotated, Literal

import pytest
import tyro

from avsec_gym.commands.arguments import options, parse
from avsec_gym.errors import ConfigurationError


@dataclass(frozen=True)
class Wheel:
    """What turns."""

    turn_speed: float = 1.0
    """Of the wheel, rad/s."""


@dataclass(frozen=True)
class Turn:
    """Turn a wheel."""

    way: Annotated[Literal["left", "right"], tyro.conf.Positional]
    """Which way."""
    limit: int | None = None
    """How often.  Default:
    for ever."""
    quiet: bool = False
    """Say nothing."""
    oiled: bool = field(default=True, metadata={"help": "Do not oil it first."})
    """Whether it is oiled first."""
    speed: Literal["slow", "fast"] | None = None
    """How fast."""
    wheel: Wheel = field(default_factory=Wheel)
    """The wheel."""


def test_words_become_a_command() -> None:
    assert parse(Turn, ["left"], "avsec turn") == Turn("left")
    words = ["right", "--limit", "3", "--no-oiled", "--speed", "fast", "--turn_speed=2.5"]
    asked = Turn("right", 3, oiled=False, speed="fast", wheel=Wheel(2.5))
    assert parse(Turn, words, "avsec turn") == asked
    assert [option.flag for option in options(Turn)] == [
        "--limit", "--quiet", "--no-oiled", "--speed", "--turn-speed",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["left", "--oild"], 'no option --oild. Did you mean "--no-oiled"?'),
        (["left", "--turn_sped", "3"], 'Did you mean "--turn-speed"?'),
        (["left", "--hlep"], 'no option --hlep. Did you mean "--help"?'),
        (["left", "--zzz"], "no option --zzz. `avsec turn --help` lists all."),
        (["lift"], 'way cannot be lift. Did you mean "left"? Known: left, right'),
        (["left", "--speed", "None"], "--speed cannot be None. Known: slow, fast"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(words: list[str], says: str) -> None:
    with pytest.raises(ConfigurationError, match=re.escape(says)):
        parse(Turn, words, "avsec turn")


def test_what_python_calls_nothing_cannot_be_typed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        parse(Turn, ["left", "--limit", "None"], "avsec turn")
    assert "None" in capsys.readouterr().err


def test_the_help(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    with pytest.raises(SystemExit) as end:
        parse(Turn, ["--help"], "avsec turn")
    assert end.value.code == 0
    help = " ".join(capsys.readouterr().out.replace("│", " ").split())
    for line in (
        "usage: avsec turn [-h]",
        "{left,right} Which way. (required)",
        "--limit INT How often. Default: for ever. --quiet Say nothing. --no-oiled Do not oil it",
        "--speed {slow,fast} How fast.",
        "--turn-speed FLOAT Of the wheel, rad/s. (default: 1.0)",
    ):
        assert line in help
