"""The best constant is searched for every attacker, and what is found is kept."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.registration import CATALOGUE
from studies.attackers import attacked_games, constants
from studies.attackers.attacked_games import GAMES, AttackedGame, ConstantFound, constant_of

ATTACKERS = ("Attack-v", "Spoofing-v", "GhostObject-v")


def test_every_attacker_of_the_catalogue_is_a_game() -> None:
    attackers = {entry.id for entry in CATALOGUE if any(word in entry.id for word in ATTACKERS)}
    assert {game.env for game in GAMES.values()} == attackers
    # Under its own name each has its default arguments.
    for entry in attackers:
        assert not GAMES[entry.removeprefix("avsec/")].arguments


def test_scenes_to_be_judged_by_are_others() -> None:
    for game in GAMES.values():
        searched, judged = game.scenes
        assert searched != judged


def test_a_constant_is_found_and_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    """In the game that one solves, a short search wins more than chance, which is 3 %."""
    scenes = (
        {"name": "layouts", "seed": 0, "count": 8},
        {"name": "layouts", "seed": 7, "count": 8},
    )
    small = AttackedGame("avsec/GhostObject-v0", scenes, 8000, 100, 256)
    monkeypatch.setitem(attacked_games.GAMES, "small", small)
    found = constant_of("small", 0)
    assert found.steps <= 8000
    assert len(found.action) == 8
    assert found.held_out.of == found.searched.of == 100
    assert found.searched.rate is not None
    assert found.searched.rate > 0.1


def in_this_process(
    prepare: Callable[[], Callable[[str], Any]], tasks: list[str], *_: Any, **__: Any
) -> Any:
    work = prepare()
    return ((task, work(task)) for task in tasks)


def test_what_is_kept_is_not_searched_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    searched: list[str] = []

    def find(name: str) -> ConstantFound:
        searched.append(name)
        share = share_of([True, False], ["a", "b"])
        return ConstantFound(GAMES[name].env, {}, 10, (0.5,), share, share)

    monkeypatch.setattr(constants, "each_in_processes", in_this_process)
    monkeypatch.setattr(constants, "searching", lambda seed: find)
    words = ["GhostObject-v0", "GhostObject-v1", "--runs", str(tmp_path), "--json"]
    assert constants.main([*words, str(tmp_path / "a.json")]) == 0
    assert constants.main([*words, str(tmp_path / "b.json")]) == 0
    assert searched == ["GhostObject-v0", "GhostObject-v1"]
    result = json.loads((tmp_path / "b.json").read_text())
    assert result == json.loads((tmp_path / "a.json").read_text())
    assert result["games"]["GhostObject-v1"]["held_out"]["rate"] == 0.5
    # Another seed is another search.
    assert (
        constants.main(["GhostObject-v0", "--seed", "1", *words[2:], str(tmp_path / "c.json")]) == 0
    )
    assert len(searched) == 3
