"""Names, dictionaries and live objects; plug-ins that work and plug-ins that do not."""

from __future__ import annotations

import ast
import logging
import re
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import avsec_gym.commands
from avsec_gym import registry
from avsec_gym.attacks.attacked_detector import AttackedDetector
from avsec_gym.attacks.noise import RandomNoise
from avsec_gym.built_in_parts import ALL_PLANNERS, RESERVED
from avsec_gym.errors import ConfigurationError
from avsec_gym.planners.planner import Algorithm, Mode, MotionPrimitivePlanner
from avsec_gym.registry import Kind, check, make, names, register


@pytest.fixture(autouse=True)
def _fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing that a test registers stays."""
    monkeypatch.setattr(registry, "_REGISTERED", {})
    monkeypatch.setattr(registry, "_PLUGINS_LOADED", False)


@pytest.fixture
def plug_in(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Pretend that packages are installed which have these entry points."""

    def install(**functions: Any) -> None:
        def load(what: Any) -> Any:
            if isinstance(what, Exception):
                raise what
            return what

        points = [
            SimpleNamespace(name=name, load=lambda what=what: load(what))
            for name, what in functions.items()
        ]

        def entry_points(*, group: str) -> list[SimpleNamespace]:
            return points if group == "avsec_gym.plugins" else []

        monkeypatch.setattr(metadata, "entry_points", entry_points)

    return install


def test_by_name_by_dictionary_and_as_it_is() -> None:
    assert make("planner", "astar") == MotionPrimitivePlanner()
    assert make(Kind.PLANNER, "gbfs").algorithm == Algorithm.GBFS
    given = make("planner", {"name": "astar", "node_limit": 7, "mode": "reference"})
    assert (given.node_limit, given.mode) == (7, Mode.REFERENCE)
    live = MotionPrimitivePlanner(node_limit=3)
    assert make("planner", live) is live
    assert make("attack", {"name": "random_noise", "strength": 5}) == RandomNoise(5)


def test_the_dictionary_is_left_as_it_was() -> None:
    asked = {"name": "astar", "node_limit": 7}
    make("planner", asked)
    assert asked == {"name": "astar", "node_limit": 7}


def test_one_can_add_ones_own() -> None:
    register("detector", "mine", lambda size=1: ("mine", size))
    assert make("detector", "mine") == ("mine", 1)
    assert make("detector", {"name": "mine", "size": 4}) == ("mine", 4)
    assert "mine" in names("detector")
    assert "oracle" in names("detector")
    # The same name means something else for another kind.
    register("validator", "mine", lambda: "another")
    assert make("validator", "mine") == "another"


@pytest.mark.parametrize("name", ["astar", "mine"])
def test_a_name_is_given_once(name: str) -> None:
    register("planner", "mine", lambda: 1)
    with pytest.raises(ConfigurationError, match=f"named '{name}' already"):
        register("planner", name, lambda: 2)
    assert make("planner", "mine") == 1


@pytest.mark.parametrize("key", RESERVED, ids=str)
def test_a_name_that_commands_take_for_something_else(key: tuple[Kind, str]) -> None:
    """A plug-in's planner "all" could not be asked for: `--planner all` is the package's own."""
    with pytest.raises(ConfigurationError, match=f"cannot be named '{key[1]}'.*another name"):
        register(*key, lambda: 1)
    with pytest.raises(ConfigurationError, match=f"named '{key[1]}'"):
        make(*key)


def test_whatever_a_command_takes_beside_names_is_reserved() -> None:
    """Words that are compared with what was typed for a part, in the commands' own sources."""
    compared = set()
    for path in Path(avsec_gym.commands.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.Eq):
                sides = [ast.unparse(side) for side in (node.left, *node.comparators)]
                kinds = [kind for kind in Kind if f"self.{kind}" in sides]
                kinds += [Kind.PLANNER] if path.stem == "named_planner" else []
                compared |= {(kind, side) for kind in kinds for side in sides}
    words = {side for _, side in compared if not side.startswith("self.") and side != "text"}
    assert words == {"ALL_PLANNERS"}
    assert (Kind.PLANNER, ALL_PLANNERS) in RESERVED


@pytest.mark.parametrize(
    "name", ["", " ", "{mine}", "a,b", "a/b", "../mine", "-mine", "two words", "x" * 101, 5, None]
)
def test_a_name_that_cannot_be_typed(name: Any) -> None:
    with pytest.raises(ConfigurationError, match="cannot be named"):
        register("planner", name, lambda: 1)


def test_unknown_names_list_the_known_ones() -> None:
    register("planner", "rrt", lambda: 1)
    with pytest.raises(ConfigurationError, match=r"no planner named 'dijkstra'.*astar, gbfs, rrt"):
        make("planner", "dijkstra")
    with pytest.raises(ConfigurationError, match="random_noise"):
        make("attack", "")


def test_an_attack_on_detections_is_no_attack_on_frames() -> None:
    """It would be made, and fail at the first frame."""
    for what in ("random_ghosts", {"name": "random_ghosts", "ghosts": 5}):
        for ask in (make, check):
            with pytest.raises(ConfigurationError, match=r"no attack on frames.*RandomGhosts"):
                ask("attack", what)
        with pytest.raises(ConfigurationError, match=r"attack: .*no attack on frames"):
            AttackedDetector("oracle", what)
    assert "random_ghosts" not in names("attack")


def test_a_bare_pgd_is_an_error_that_names_both_forms() -> None:
    for ask in (make, check):
        for what in ("pgd", {"name": "pgd", "alpha": 1.0}):
            with pytest.raises(ConfigurationError, match=r"'thesis_pgd'.*Madry.*'projected_pgd'"):
                ask("attack", what)
    with pytest.raises(ConfigurationError, match="choose another"):
        register("attack", "pgd", lambda: 1)
    assert {"thesis_pgd", "projected_pgd"} <= set(names("attack"))
    assert "pgd" not in names("attack")
    assert not make("attack", "thesis_pgd").projected
    assert make("attack", {"name": "projected_pgd", "random_start": False}).projected


def test_unknown_kinds_list_the_known_ones() -> None:
    with pytest.raises(
        ConfigurationError, match="detector, attack, classifier, selector, planner, validator"
    ):
        make("camera", "astar")
    with pytest.raises(ConfigurationError, match="no kind of part"):
        register("camera", "mine", lambda: 1)


def test_arguments_that_do_not_fit() -> None:
    for ask in (make, check):
        with pytest.raises(ConfigurationError, match=r"no argument 'node_limt'.*\"node_limit\"\?"):
            ask("planner", {"name": "astar", "node_limt": 3})
    with pytest.raises(ConfigurationError, match="needs a 'name'"):
        make("planner", {"node_limit": 3})


def test_plug_ins_are_loaded_when_a_name_is_asked_for(plug_in: Callable[..., None]) -> None:
    calls = []

    def mine() -> None:
        calls.append(1)
        register("planner", "theirs", lambda: "planned")

    plug_in(mine=mine)
    assert not calls
    assert names("planner") == ["astar", "gbfs", "theirs"]
    assert make("planner", "theirs") == "planned"
    assert calls == [1]


def test_a_broken_plug_in_does_not_take_the_others_with_it(
    plug_in: Callable[..., None], caplog: pytest.LogCaptureFixture
) -> None:
    def fails() -> None:
        raise RuntimeError("half installed")

    plug_in(
        absent=ImportError("no such module"),
        fails=fails,
        wrong=5,
        taken=lambda: register("planner", "astar", lambda: 1),
        good=lambda: register("planner", "theirs", lambda: "planned"),
    )
    with caplog.at_level(logging.WARNING):
        assert make("planner", "theirs") == "planned"
    assert make("planner", "astar") == MotionPrimitivePlanner()
    told = [record.getMessage() for record in caplog.records]
    assert len(told) == 4
    for name, message in zip(("absent", "fails", "wrong", "taken"), told, strict=True):
        assert f"plug-in {name} " in message
    assert "half installed" in told[1]


def test_a_plug_in_may_ask_for_names_itself(plug_in: Callable[..., None]) -> None:
    calls = []

    def polite() -> None:
        calls.append(1)
        if "polite" not in names("planner"):
            register("planner", "polite", lambda: make("planner", "astar"))

    plug_in(polite=polite)
    assert make("planner", "polite") == MotionPrimitivePlanner()
    assert calls == [1]


@pytest.mark.parametrize(
    ("kind", "name", "said"),
    [
        ("detector", "yolo", "'yolo' is a detector of 2D boxes, and a detector of 3D boxes is"),
        ("attack", "facula", "is an optical attack and a drive attack, and an attack is needed"),
        ("optical_attack", "thesis_pgd", "is an attack, and an optical attack is needed here"),
        ("optical_attack", "facul", "there is no optical attack named 'facul'. Did you mean"),
    ],
)
def test_a_name_of_another_kind_says_which(kind: str, name: str, said: str) -> None:
    with pytest.raises(ConfigurationError, match=re.escape(said)):
        check(kind, name)
