"""What runs and weights keep of the command that made them."""

import shlex
import sys

import pytest

from avsec_gym.command_line import command_line


@pytest.mark.parametrize(
    ("program", "typed"),
    [
        ("/home/ada/.venv/bin/avsec", "avsec"),
        ("/home/ada/src/avsec_gym/__main__.py", "avsec"),
        ("/home/ada/src/my_lab/__main__.py", "/home/ada/src/my_lab/__main__.py"),
        ("examples/train_laser.py", "examples/train_laser.py"),
    ],
)
def test_the_command_can_be_typed_again(
    monkeypatch: pytest.MonkeyPatch, program: str, typed: str
) -> None:
    arguments = ["run", "identification", "--out", "two words", "--options", "a=b;c"]
    monkeypatch.setattr(sys, "argv", [program, *arguments])
    assert shlex.split(command_line()) == [typed, *arguments]
