"""What holds for every attack on a driving car."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.closed_loop.attack.drive_attack import DriveAttack, object_at
from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind, make, names
from tests.closed_loop.attack.surroundings import around

START = (0.0, 0.0, 0.0)


@pytest.mark.parametrize("name", names(Kind.DRIVE_ATTACK))
def test_every_kind_keeps_its_sizes_and_its_keys(name: str) -> None:
    attack: DriveAttack = make(Kind.DRIVE_ATTACK, name)
    random, keys = np.random.default_rng(0), list(attack.facts)
    for step in range(50):
        seen = around((0.5 * step, 0.0, 0.0))
        effort = attack.act(random.uniform(-1, 1, attack.action_size), seen)
        assert 0.0 <= effort <= 1.0
        assert attack.state(seen).shape == (attack.state_size,)
        assert np.isfinite(attack.state(seen)).all()
        assert list(attack.facts) == keys
        assert (effort > 0) == bool(attack.state(seen).any())
    attack.begin()
    assert not attack.state(around(START)).any()


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("ghost", {"hides": 17}),
        ("facula", {"radii": [9, 3]}),
        ("spoofed_scan", {"widths": [0, 1]}),
        ("patch", {"diameters": [2, 1]}),
    ],
)
def test_numbers_out_of_range_are_refused(name: str, wrong: dict[str, object]) -> None:
    with pytest.raises(ConfigurationError, match=next(iter(wrong))):
        make(Kind.DRIVE_ATTACK, {"name": name, **wrong})


def test_the_object_at_a_place_is_the_nearest_one() -> None:
    assert object_at(around(START), 22.0, 4.0) == 9
    assert object_at(around((0.0, 0.0, np.pi / 2)), 0.0, -29.0) == 7
    assert object_at(around(START, np.zeros((0, 3))), 22.0, 4.0) is None
