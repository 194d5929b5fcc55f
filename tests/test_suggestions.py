"""Unknown names, and what they may have meant."""

from __future__ import annotations

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind, make, names
from avsec_gym.suggestions import did_you_mean, unknown_name

COMMANDS = ["evaluate", "plan", "layouts", "report"]


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("evalute", "evaluate"),
        ("layout", "layouts"),
        ("Report ", "report"),
        ("paln", "plan"),
    ],
)
def test_a_slip_is_recognised(name: str, meant: str) -> None:
    assert did_you_mean(name, COMMANDS) == f'Did you mean "{meant}"?'


def test_nothing_near_is_no_question() -> None:
    assert did_you_mean("xyz", COMMANDS) == ""
    assert did_you_mean("", COMMANDS) == ""
    assert did_you_mean("plan", []) == ""


def test_capitals_and_joints_do_not_count() -> None:
    assert did_you_mean("Stereo-RCNN", ["dsgn", "stereo_rcnn"]) == 'Did you mean "stereo_rcnn"?'
    assert did_you_mean("stereo rcnn", ["Stereo-RCNN"]) == 'Did you mean "Stereo-RCNN"?'


def test_a_message_says_what_was_wrong_what_was_meant_and_what_there_is() -> None:
    said = unknown_name("there is no command 'paln'", "paln", iter(COMMANDS))
    assert said == (
        "there is no command 'paln'. Did you mean \"plan\"? Known: evaluate, plan, layouts, report"
    )
    said = unknown_name("there is no command 'xyz'", "xyz", COMMANDS)
    assert said == "there is no command 'xyz'. Known: evaluate, plan, layouts, report"


@pytest.mark.parametrize("kind", list(Kind))
def test_the_registry_asks_about_every_name_with_a_slip(kind: Kind) -> None:
    for name in names(kind):
        with pytest.raises(ConfigurationError, match=f'Did you mean "{name}"') as raised:
            make(kind, name + "x")
        assert f"there is no {kind.replace('_', ' ')} named '{name}x'." in str(raised.value)


def test_so_with_the_kinds() -> None:
    with pytest.raises(ConfigurationError, match='Did you mean "planner"'):
        make("planer", "astar")
