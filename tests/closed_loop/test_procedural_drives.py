"""Procedural drives are made of the part of the assets that is asked for."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.closed_loop.loop_scenes import loop_scenes
from avsec_gym.closed_loop.rendered_sensors import RenderedSensors
from avsec_gym.envs.closed_loop_parts import checked_scenarios
from avsec_gym.errors import ConfigurationError
from avsec_gym.world.assets import Assets, part_of
from avsec_gym.world.drives import DriveScenes
from avsec_gym.world.models.vehicles import make_vehicle, vehicle
from avsec_gym.world.models.vehicles.designs import body_designs, choose_design

ALL_DESIGNS = {design.name for design in body_designs("Car", Assets.ALL)}
JUDGING_DESIGNS = {design.name for design in body_designs("Car", Assets.JUDGE)}


def scenes_of(assets: str | None, vehicles: int = 1) -> DriveScenes:
    """The drive of a number, rendered from nowhere yet."""
    part = {} if assets is None else {"assets": assets}
    scenes = loop_scenes("drives", seed=3, count=1, vehicles=vehicles, **part)  # type: ignore[arg-type]
    sensors = scenes.scene(scenes.ids[0]).sensors
    assert isinstance(sensors, RenderedSensors)
    return sensors.scenes


def car_designs(scenes: DriveScenes, monkeypatch: pytest.MonkeyPatch) -> set[str]:
    """Names of the body designs of all cars of a drive."""
    names = set()

    def noted(*arguments):  # type: ignore[no-untyped-def]
        design = choose_design(*arguments)
        names.add(design.name)
        return design

    monkeypatch.setattr(vehicle, "choose_design", noted)
    actors = scenes.world.instants[0].actors
    for index in np.flatnonzero(actors.category == "Car").tolist():
        height, width, length = actors.dimensions[index].tolist()
        make_vehicle("Car", (height, width, length), int(actors.appearance[index]))
    monkeypatch.undo()
    return names


def test_a_drive_of_the_judging_part_shows_judging_designs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    judging, every = scenes_of("judge"), scenes_of("all")
    assert part_of(judging.world.site.seed) == Assets.JUDGE
    shown = car_designs(judging, monkeypatch)
    assert shown
    assert shown <= JUDGING_DESIGNS < ALL_DESIGNS
    assert car_designs(every, monkeypatch) - JUDGING_DESIGNS, "all of them have some of both"


def test_all_assets_are_the_usual_ones() -> None:
    for usual, every in zip(
        scenes_of(None).world.instants, scenes_of("all").world.instants, strict=True
    ):
        assert np.array_equal(usual.actors.appearance, every.actors.appearance)
    assert loop_scenes("drives", seed=3, count=1, assets="all").ids == ("drive-s3-000000",)


def test_ids_name_a_part_and_connected_vehicles_share_it() -> None:
    assert loop_scenes("drives", count=1, assets="judge").ids == ("drive-judge-000000",)
    connected = loop_scenes("drives", seed=3, count=1, vehicles=2, assets="judge")
    assert connected.ids == ("drive-s3-v2-judge-000000",)
    scene = connected.scene("drive-s3-v2-judge-000000")
    assert scene.id in connected.ids
    scenes = scenes_of("judge", vehicles=2)
    assert len(scenes.world.instants[0].egos) == 2
    appearances = scenes.world.instants[0].actors.appearance.tolist()
    assert {part_of(seed) for seed in appearances} == {Assets.JUDGE}


def test_what_is_no_part_is_refused_as_soon_as_it_is_named() -> None:
    for refusing in (checked_scenarios, lambda what: loop_scenes(**what)):
        with pytest.raises(ConfigurationError, match=r"part of the assets 'judgement'.*judge"):
            refusing({"source": "drives", "assets": "judgement"})
    with pytest.raises(ConfigurationError, match="assets is for drives, not for layouts"):
        loop_scenes("layouts", assets="judge")
    assert checked_scenarios({"source": "drives", "assets": "judge"})["assets"] == "judge"
