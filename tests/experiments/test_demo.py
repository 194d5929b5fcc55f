"""The demo: which cells it asks for, and what its table says."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from avsec_gym.attacks.patch_files import Patch, PatchCard, save_patch
from avsec_gym.boxes import Boxes3D
from avsec_gym.commands.demo import Demo
from avsec_gym.experiments import procedural_frames
from avsec_gym.experiments.chapter5 import attacked_cells, attacked_episodes, true_episodes
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.tables import precision_rows
from avsec_gym.experiments.demo import contested_frames
from avsec_gym.experiments.demo import rates as demo_rates
from avsec_gym.experiments.demo.experiment import DEMO, FULL_REPORT, SCENES, unpatched
from avsec_gym.experiments.demo.patch_in_words import grey_in_words
from avsec_gym.experiments.demo.rates import demo_rows
from avsec_gym.experiments.demo.section import rate_table
from avsec_gym.experiments.demo.story import HIT, contested_ways, hits, sentences, story_rows
from avsec_gym.metrics.average_precision_curves import best_average_precisions
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.runs.catalogue import experiment
from avsec_gym.runs.experiment import Configuration, with_defaults
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_set import SceneSet


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(Path(__file__).parent / "chapter5")
    import made_results

    return made_results


def test_only_patches_that_were_trained_are_put_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenes = SceneSet("one", (Scene("000000", Boxes3D.empty()),))
    for module in (attacked_cells, attacked_episodes, true_episodes):
        monkeypatch.setattr(module, "scenes_of", lambda asked: FrameScenes(scenes, {}))
    save_patch(tmp_path / "dsgn.safetensors", Patch.grey())
    asked = with_defaults(Configuration(options={"patches": str(tmp_path)}), [DEMO])
    assert unpatched(asked.options) == ("stereo_rcnn",)
    found = [cell.arguments for cell in DEMO.cells(asked)]
    assert [(rates.get("detector"), rates.get("attack")) for rates in found] == [
        (None, None),
        *(("dsgn", attack) for attack in ("unattacked", "thesis_pgd-1", "patch-random")),
        *(("stereo_rcnn", attack) for attack in ("unattacked", "thesis_pgd-1")),
    ]
    assert experiment("demo") is DEMO
    assert (DEMO.usual.scenarios, DEMO.usual.limit) == ("procedural_contested", SCENES)
    assert Demo().scenarios == SCENES


def test_frames_made_ahead_are_those_that_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def cached(name: str, recipe: Any, workers: int | None = None, **_: Any) -> Path:
        asked.append((name, len(recipe), recipe.settings))
        return Path(name)

    for module in (contested_frames, procedural_frames):
        monkeypatch.setattr(module, "cached", cached)
    contested_frames.contested_frames(2, 3, processes=1)
    procedural_frames.procedural_frames(2, 3, contested=True)
    assert asked[0] == asked[1]


def test_the_table_pools_intentions_and_takes_the_strongest_step(made: ModuleType) -> None:
    names = made.names(6)
    results = made.MadeResults()
    results.add(Condition("dsgn"), names)
    results.add(Condition("dsgn", "thesis_pgd-1", 1.0), names)
    results.add(Condition("dsgn", "thesis_pgd-1", 4.0), names, lost=names, unsafe=names[:2])
    results.add(Condition("dsgn", "patch-specific"), names, unsafe=names[:3], outcome="unplanned")
    results.episodes["ground_truth", 0.0, "astar"] = [
        made.record(name, way) for name in names for way in Intention
    ]
    found = made.outcomes(results, names)
    rows = demo_rows(found)
    assert [(row.detector, row.attack, row.strength) for row in rows] == [
        (None, "unattacked", 0.0),
        ("dsgn", "unattacked", 0.0),
        ("dsgn", "thesis_pgd-1", 4.0),
        ("dsgn", "patch-specific", 0.0),
    ]
    truth, clean, pgd, patch = rows
    assert truth.rates.safe_driving_rate == 1.0
    assert truth.precision is None
    strict = {
        row.condition.strength: row.precision["3d"]["ap11"][1]
        for row in precision_rows(found)
        if row.condition.attack != "patch-specific"
    }
    assert clean.precision == clean.precision_iou_low == pytest.approx(strict[0.0], abs=1e-3)
    assert clean.precision > 0
    assert truth.precision_ceiling is None
    assert clean.labels == found.precision(next(iter(found.strongest))).labels[0, 1]
    assert clean.precision_ceiling == best_average_precisions(clean.labels)[0]
    assert patch.precision == clean.precision
    assert pgd.precision == pgd.precision_iou_low == 0.0
    assert pgd.rates.scenarios == 18
    assert pgd.rates.collision_rate == pytest.approx(1 / 3)
    # Three intentions of a scene that always end alike say as much as one.
    assert pgd.rates.to_json()["collision_rate_interval"] == pytest.approx(
        list(wilson_interval(2, 6))
    )
    assert (patch.rates.success_rate, patch.rates.collision_rate) == (0.5, 0.0)


def test_few_scenes_are_called_few_and_precision_has_intervals_where_there_are_more(
    made: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = made.names(6)
    results = made.MadeResults()
    results.add(Condition("dsgn"), names)
    results.add(Condition("dsgn", "patch-random"), names, lost=names[:2])
    few = demo_rows(made.outcomes(results, names))
    table = rate_table(few, len(names))
    assert [row.precision_interval for row in few] == [None] * 3
    assert "6 scenes show what attacks do, not how often" in table.note
    assert "bootstrap" not in table.note
    assert table.rows[-1][1].text == "trained patch, random place"

    monkeypatch.setattr(demo_rates, "FULL_REPORT", len(names))
    found = made.outcomes(results, names)
    _, clean, patch = demo_rows(found)
    strict = precision_rows(found)[-1].precision["3d"]["ap11_interval"][1]
    assert patch.precision_interval == pytest.approx(strict, abs=1e-3)
    assert (clean.precision, patch.precision) == (few[1].precision, few[2].precision)
    table = rate_table([few[0], clean, patch], FULL_REPORT)
    assert "not how often" not in table.note
    assert "of AP by bootstrap over scenes" in table.note
    assert all(cell.interval for cell in table.rows[-1][-2:])


class MadeRun:
    """What is asked of a run: its patches' folder, and their hashes."""

    def __init__(self, patches: Path, hashes: dict[str, str]) -> None:
        self.configuration = Configuration(options={"patches": str(patches)})
        inputs = {f"patch {name}": {"sha256": sha256} for name, sha256 in hashes.items()}
        self.manifest = {"inputs": inputs}


def test_a_grey_patch_is_named_beside_a_trained_one_by_the_card_of_the_run(tmp_path: Path) -> None:
    losses = {"dsgn": (2.1112, 2.1031), "stereo_rcnn": (3.6433, -7.4539)}
    hashes = {}
    for detector, (grey, trained) in losses.items():
        card = PatchCard(losses={"grey": {detector: grey}, "patch": {detector: trained}})
        patch = Patch(Patch.grey().pixels, card=card)
        kept = save_patch(tmp_path / f"{detector}.safetensors", patch).card
        assert kept is not None
        hashes[detector] = kept.sha256
    run: Any = MadeRun(tmp_path, hashes)
    words = grey_in_words(run, losses)
    assert "against DSGN 2.111 grey and 2.103 trained, so that grey does about the same;" in words
    assert words.endswith("against Stereo R-CNN 3.643 grey and −7.454 trained.")
    # Of another patch than the run's, of none, and without losses nothing is known.
    other: Any = MadeRun(tmp_path, {**hashes, "dsgn": "0" * 64})
    assert "DSGN" not in grey_in_words(other, losses)
    assert grey_in_words(run, ["joint"]) == ""
    assert grey_in_words(run, []) == ""
    save_patch(tmp_path / "dsgn.safetensors", Patch.grey())
    assert grey_in_words(run, ["dsgn"]) == ""


def test_the_story_counts_cars_and_the_episodes_in_which_something_is_in_the_way(
    made: ModuleType,
) -> None:
    names = made.names(4)
    results = made.MadeResults()
    attacked = Condition("dsgn", "thesis_pgd-1", 4.0)
    results.add(Condition("dsgn"), names, unsafe=names[3:])
    results.add(attacked, names, lost=names[:3], unsafe=names[1:])
    found = made.outcomes(results, names)
    ways = {(names[0], Intention.LEFT), (names[1], Intention.RIGHT), (names[3], Intention.LEFT)}
    clean, pgd = story_rows(found, ways, 0.3)
    cars = sum(int((found.labels[name].category == "Car").sum()) for name in names)
    assert (clean.found, clean.cars, clean.safe, clean.episodes) == (cars, cars, 2, 3)
    assert (pgd.found, pgd.cars, pgd.safe, pgd.episodes) == (cars // 4, cars, 1, 3)
    tried, happened = sentences([clean, pgd])
    assert "these 3 episodes" in tried
    assert f"DSGN finds {cars} of {cars} cars" in happened
    assert "safely in 2 of 3" in happened
    assert f"; thesis PGD α 1, n 4: {cars // 4} cars, safely in 1." in happened
    assert list(sentences(story_rows(found, set(), 0.3))) == []
    # The episode that was made unsafe, not that which was unsafe before, nor one with a free way.
    first, *others = hits(found, ways, 4, 0.3)
    assert (first.rule, first.scenario, first.intention) == (HIT, names[1], Intention.RIGHT)
    assert first.conditions == (Condition("dsgn"), attacked)
    assert names[1] not in {other.scenario for other in others}
    assert len(hits(found, ways, 1, 0.3)) == 1


def test_ways_are_contested_where_a_parked_car_has_to_be_seen(made: ModuleType) -> None:
    scenes = (Scene("parked", made.car(x=-3.5, z=10.0)), Scene("free", Boxes3D.empty()))
    assert contested_ways(FrameScenes(SceneSet("two", scenes), {})) == {("parked", Intention.LEFT)}
