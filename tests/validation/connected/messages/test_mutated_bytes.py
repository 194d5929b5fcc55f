"""Damaged bytes of every kind of message are refused by name, or hold what a message may hold."""

from __future__ import annotations

import sys
from pathlib import Path
from random import Random

import pytest

from avsec_gym.errors import DataError

sys.path.append(str(Path(__file__).parents[4] / "benchmarks" / "fuzz"))
from connected_files import MESSAGE
from kinds import KINDS

_MESSAGES = [kind for kind in KINDS.values() if kind.file == MESSAGE]


def test_every_kind_of_message_is_here() -> None:
    assert len(_MESSAGES) == 4


@pytest.mark.parametrize("kind", _MESSAGES, ids=lambda kind: kind.name)
def test_damaged_messages_are_refused_or_sound(kind, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    kind.make(tmp_path)
    sound = (tmp_path / MESSAGE).read_bytes()
    kind.read(tmp_path)
    outcomes = {"read": 0, "refused": 0}
    for seed in range(150):
        random = Random(seed)
        content = kind.mutators[random.choice(sorted(kind.mutators))](sound, random)
        (tmp_path / MESSAGE).write_bytes(content)
        message = ""
        try:
            assert kind.impossible(kind.read(tmp_path)) is None
        except DataError as error:
            message = str(error)
        outcomes["refused" if message else "read"] += 1
        assert not message or MESSAGE in message
    assert min(outcomes.values()) > 0
