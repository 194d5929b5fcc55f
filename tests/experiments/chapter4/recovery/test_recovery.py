"""What recovered scans save: the scene around the car, the rates, the section, and one place."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter4.procedural_instants import ScannedPlace
from avsec_gym.experiments.chapter4.recovery.cells import RECOVERY, RecoveredEpisodes
from avsec_gym.experiments.chapter4.recovery.driven_instant import scene_around
from avsec_gym.experiments.chapter4.recovery.rates import is_of_recovery, recovery_rows
from avsec_gym.experiments.chapter4.recovery.section import recovery_section
from avsec_gym.experiments.chapter4.settings import FIVE, JUDGED
from avsec_gym.metrics.safety import COLLISION, SAFE, UNPLANNED, SafetyRecord
from avsec_gym.registry import Kind, make
from avsec_gym.runs.experiment import Configuration
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.proposals.sectors import SectorProposer
from avsec_gym.validation.connected.recovery import recovered_scan
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.world.drives import drive_scenes
from avsec_gym.world.export import instant_of
from avsec_gym.world.labels import boxes_in_camera


def test_the_scene_around_the_car_is_that_of_its_labels() -> None:
    posed = drive_scenes(1, 0, 1, 3)[0]
    actors, egos = posed.instant.actors, posed.instant.egos
    truth = instant_of(posed.instant, 0, 0, [0.0] * 3, [np.zeros(len(actors), np.int64)] * 3)
    pose = posed.vehicle_to_world[0] @ posed.rig.velodyne_pose
    road_type, calibration = posed.site.road_type, posed.rig.calibration
    scene = scene_around(truth, pose, calibration, id="a", road_type=road_type)
    # The world's own conversion, by which it labels.
    location, rotation_y = boxes_in_camera(actors, posed.rig, posed.vehicle_to_world[0])
    listed = {each.actor for each in truth.objects} - {int(actors.id[egos[0]])}
    kept = np.isin(actors.id, list(listed)) & (location[:, 2] > 0.5) & (location[:, 2] < 90)
    assert kept.sum() == len(scene.boxes) > 3
    np.testing.assert_allclose(scene.boxes.location, location[kept], atol=1e-4)
    turned = np.cos(scene.boxes.rotation_y - rotation_y[kept])
    np.testing.assert_allclose(turned, 1.0, atol=1e-4)
    np.testing.assert_allclose(scene.boxes.dimensions, actors.dimensions[kept], atol=1e-5)
    np.testing.assert_array_equal(scene.boxes.moving, actors.moving[kept])


_RECORD = SafetyRecord("0", "straight", SAFE, 1.0, 1, 1.0, 1.0)


@dataclass(frozen=True)
class _Run:
    """Outcomes by setting, one for each scenario."""

    outcomes: dict[str, tuple[str, ...]]

    def settings(self) -> list[tuple[str, float]]:
        return [(setting, 0.0) for setting in self.outcomes]

    def records(self, *, setting: str) -> list[SafetyRecord]:
        return [
            replace(_RECORD, scenario=str(number), outcome=outcome)
            for number, outcome in enumerate(self.outcomes.get(setting, ()))
        ]


_OUTCOMES = {
    "truth": (SAFE, SAFE, UNPLANNED, SAFE),
    "pixor clean alone": (SAFE, SAFE, UNPLANNED, SAFE),
    "pixor clean connected": (SAFE, SAFE, UNPLANNED, SAFE),
    "pixor ghost alone": (UNPLANNED, COLLISION, UNPLANNED, SAFE),
    "pixor ghost connected": (SAFE, SAFE, UNPLANNED, UNPLANNED),
}


def test_stops_are_needless_where_a_car_that_knows_all_drives_on() -> None:
    results: Any = _Run(_OUTCOMES)
    rows = recovery_rows(results)
    assert [(row.case, row.car) for row in rows] == [
        ("clean", "alone"),
        ("clean", "connected"),
        ("ghost", "alone"),
        ("ghost", "connected"),
    ]
    alone, connected = rows[2:]
    assert (alone.collisions.count, alone.collisions.of) == (1, 4)
    assert (alone.needless_stops.count, alone.needless_stops.of) == (1, 3)
    assert (connected.collisions.count, connected.needless_stops.count) == (0, 1)
    assert (connected.safe.count, connected.safe.of) == (2, 4)
    assert rows[0].needless_stops.count == 0
    assert is_of_recovery("pixor ghost connected")
    assert not is_of_recovery("oracle none undefended")


def test_the_section_states_both_cars_of_each_attack() -> None:
    results: Any = _Run(_OUTCOMES)
    section = recovery_section(recovery_rows(results))
    assert len(section.sentences) == 2
    assert "25.0 %" in section.sentences[1]
    assert "a ghost ahead" in section.sentences[1]


def test_a_cell_for_each_place_and_no_other_scenes() -> None:
    assert len(RECOVERY.cells(replace(RECOVERY.usual, limit=4))) == 4
    with pytest.raises(ConfigurationError, match="procedural"):
        RECOVERY.cells(Configuration("mixed", 4))


@pytest.mark.slow
def test_a_place_is_driven_through_alone_and_connected() -> None:
    work = RecoveredEpisodes(replace(RECOVERY.usual, options={"detector": "scan_obstacles"}))
    result = work(1)
    settings = {row.setting for row in result.episodes}
    cases = {setting.split()[1] for setting in settings if is_of_recovery(setting)}
    assert {"clean", "ghost"} <= cases
    for case in cases:
        assert {f"scan_obstacles {case} {car}" for car in ("alone", "connected")} <= settings
    assert sum(row.setting == "truth" for row in result.episodes) == 3
    assert len(result.episodes) == 3 + 6 * len(cases)


@pytest.mark.slow
def test_a_ghost_that_the_learned_proposer_covers_is_taken_out() -> None:
    instant = ScannedPlace(0, JUDGED, 1, FIVE.vehicles).instant(FIVE)
    ahead = PastedObject(vehicle=0, distance=(6.0, 20.0), bearing=0.0)
    attacked = ahead.attack(instant, (0, 1))
    assert attacked is not None
    network = make(Kind.DETECTOR, "pointrcnn")
    validator = ConnectedValidator(
        read_connected_fit(SHIPPED_FIT).constants(),
        proposer=SectorProposer(network, least_score=0.5),
    )
    scans = attacked.instant.scans
    result = validator.validate(scans)
    assert result.accused == (0,)

    def on_ghost(scan: Any) -> int:
        world = scan.in_world()
        raised = world[:, 2] > attacked.box.centre[0, 2] + 0.36
        return int((attacked.box.contains(0, world) & raised).sum())

    recovered = recovered_scan(scans[0], 0, result)
    assert on_ghost(scans[0]) > 100
    assert on_ghost(recovered) < 0.3 * on_ghost(scans[0])
