"""The frozen instants of connected vehicles: the same in every release that has this version."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.benchmark.connected_scenes import digest_of_instant, frozen_instants
from avsec_gym.errors import ConfigurationError
from avsec_gym.world.assets import Assets


def test_this_release_makes_the_places_of_the_version() -> None:
    frozen = frozen_instants()
    for number in frozen.numbers(quick=True):
        posed = frozen.place(number).posed
        assert digest_of_instant(posed.instant) == frozen.digests[number]
        assert len(posed.instant.egos) == 3


@pytest.mark.slow
def test_it_makes_all_of_them() -> None:
    frozen = frozen_instants()
    for number, digest in frozen.digests.items():
        assert digest_of_instant(frozen.place(number).posed.instant) == digest


def test_a_quick_entry_has_the_first() -> None:
    frozen = frozen_instants()
    assert frozen.numbers(quick=True) == frozen.numbers()[: frozen.quick]
    assert len(frozen.numbers()) == len({*frozen.digests.values()})


def test_other_places_are_refused() -> None:
    frozen = frozen_instants()
    with pytest.raises(ConfigurationError, match="are not those of version 1"):
        replace(frozen, digests={0: frozen.digests[1]}).instant(0)


def test_places_are_made_of_judging_assets() -> None:
    from avsec_gym.experiments.chapter4.procedural_instants import ASSETS
    from avsec_gym.experiments.chapter4.settings import JUDGED

    assert ASSETS[JUDGED] == Assets.JUDGE


def test_the_digest_knows_millimetres_and_no_rounding_errors() -> None:
    instant = frozen_instants().place(0).posed.instant
    actors = instant.actors
    exact = replace(actors, pose=np.round(actors.pose, 3))

    def moved(by: float) -> str:
        pose = exact.pose + np.array([by, 0.0, 0.0])
        return digest_of_instant(replace(instant, actors=replace(exact, pose=pose)))

    assert moved(0.0) == moved(1e-9) != moved(0.002)
    assert digest_of_instant(replace(instant, egos=instant.egos[::-1])) != digest_of_instant(
        instant
    )
