"""Results on KITTI's own frames: a made-up data set gets a row, and nothing of it is copied."""

from __future__ import annotations

import importlib
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.benchmark import entry_sets, kitti_results, leaderboard
from avsec_gym.benchmark.entry import Entry, read_entry
from avsec_gym.benchmark.kitti_scenes import (
    FrozenLabels,
    frozen_labels,
    hashes_of,
    read_frozen_labels,
)
from avsec_gym.benchmark.making import entered
from avsec_gym.benchmark.protocol import Entered
from avsec_gym.benchmark.scene_sets import FROZEN, version_file
from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.evaluation.contested import is_contested
from avsec_gym.evaluation.rates import DETECTIONS, Detected, RatesKey, driving_safety
from avsec_gym.kitti.labels import read_labels, write_detections, write_labels
from avsec_gym.pipeline import run_episode
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion
from avsec_gym.scenario.scene_sets import labelled_scenarios, procedural_scenes

CONTESTED = 13
"""A procedural layout that is contested to the right, as `is_contested`'s example has it."""
NUMBERS = (0, 1, CONTESTED)


@pytest.fixture
def labels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of labelled scenarios, which is the frozen one."""
    root = tmp_path / "scenarios"
    scenes = procedural_scenes(CONTESTED + 1).labelled
    for number in NUMBERS:
        write_labels(root / "static_label" / f"{number:06d}.txt", scenes[number].boxes)
    write_labels(root / "dynamic_label" / "000040.txt", scenes[2].boxes)
    flags = root / "dynamic_annotation" / "000040.txt"
    flags.parent.mkdir()
    flags.write_text("0\n" * len(scenes[2].boxes))
    ways = {
        scene.id: frozenset(way for way in Intention if is_contested(scene, way))
        for scene in labelled_scenarios(root).labelled
    }
    frozen = FrozenLabels(hashes_of(root), {id: own for id, own in ways.items() if own})
    assert Intention.RIGHT in frozen.contested[f"{CONTESTED:06d}"]
    for module in (entry_sets, kitti_results):
        monkeypatch.setattr(module, "frozen_labels", lambda: frozen)
    return root


@pytest.fixture
def results(tmp_path: Path, labels: Path) -> Path:
    """What a detector found: nothing in the contested scene, the rest a little too far away."""
    folder = tmp_path / "results"
    for path in labels.glob("*_label/*.txt"):
        truth = read_labels(path)
        kept = truth if path.stem != f"{CONTESTED:06d}" else truth[:0]
        moved = kept.location + np.array([[0.0, 0.0, 0.25]])
        found = replace(kept, location=moved, score=np.linspace(0.2, 0.9, len(kept)), moving=None)
        write_detections(folder / path.name, found)
    return folder


def made(results: Path, labels: Path, root: Path, **more: Any) -> Entry:
    part = {"name": "replayed", "detections": str(results)}
    return entered(Entered.DETECTOR, part, root, labels=labels, workers=0, **more)


def test_a_made_up_data_set_gets_a_row(labels: Path, results: Path, tmp_path: Path) -> None:
    entry = made(results, labels, tmp_path / "one", name="made up")
    assert [(row.scenes, row.setting) for row in entry.rows] == [
        ("kitti", "truth"), ("kitti", "unattacked"),
        ("kitti_contested", "truth"), ("kitti_contested", "unattacked"),
    ]  # fmt: skip
    # The rates are those of `avsec evaluate`, whose code is another one.
    scenes = labelled_scenarios(labels)
    boxes = {scene.id: read_results(results / f"{scene.id}.txt") for scene in scenes.labelled}
    safety = driving_safety(
        scenes, planners=("astar",), detected=Detected(boxes), detected_motion=Motion.TRUTH
    )
    expected = [safety.rates(RatesKey("astar", str(way), DETECTIONS)) for way in Intention]
    found = entry.row("kitti", "unattacked")
    assert found is not None
    assert found.rates.scenarios == 12
    assert found.rates.planned == sum(each.planned for each in expected)
    assert found.rates.collisions == sum(each.collisions for each in expected)
    assert found.paired is not None
    assert found.precision is not None
    assert found.precision.labels > 0
    assert found.precision.ceiling < 100.0
    # Of the contested scene nothing is seen: so it is driven blindly.
    contested = entry.row("kitti_contested", "unattacked")
    assert contested is not None
    scene = next(each for each in scenes.labelled if each.id == f"{CONTESTED:06d}")
    assert not run_episode(scene, Intention.RIGHT, Boxes3D.empty()).record.safe
    assert contested.rates.safe_driving_rate < 1.0
    assert entry.row("kitti_contested", "truth").rates.safe_driving_rate == 1.0  # type: ignore[union-attr]
    assert [*entry.skipped] == ["all", "contested", "closed_loop"]
    assert (entry.white_box, entry.world, entry.weights, entry.broken) == (False, "", {}, None)
    assert [row.scenes for row in entry.scenes] == ["kitti"]


def read_results(path: Path) -> Boxes3D:
    from avsec_gym.kitti.labels import read_detections

    return read_detections(path)


def test_made_twice_it_is_the_same_and_names_no_folder(
    labels: Path, results: Path, tmp_path: Path
) -> None:
    one = made(results, labels, tmp_path / "one").to_json()
    assert made(results, labels, tmp_path / "two").to_json() == one
    assert made(results, labels, tmp_path / "one").to_json() == one
    text = (tmp_path / "one" / "entry.json").read_text()
    assert str(tmp_path) not in text
    assert read_entry(tmp_path / "one" / "entry.json").to_json() == one
    # Nothing is copied: the labels' places are named in the run, and their text is nowhere.
    line = (labels / "static_label" / f"{CONTESTED:06d}.txt").read_text().splitlines()[0]
    for path in (tmp_path / "one").rglob("*"):
        assert not path.is_file() or line.encode() not in path.read_bytes()


def test_the_command_and_the_pages_list_it(
    labels: Path, results: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "entries" / "mine"
    words = ["benchmark", "detector", str(results), "--labels", str(labels), "--name", "my own"]
    assert run([*words, "--out", str(out), "--workers", "0"]) == 0
    (section,) = leaderboard.board([read_entry(out / "entry.json")])
    (table,) = section.parts
    assert isinstance(table, leaderboard.Table)
    [cells] = table.rows
    assert len(cells) == len(table.columns)
    assert cells[0].text == "my own"
    by_column = dict(zip(table.columns, cells, strict=True))
    assert by_column["safe driving, all"].text != "–"
    assert float(by_column["ceiling, all"].text) < 100
    page = tmp_path / "board.html"
    assert run(["benchmark", "board", str(tmp_path / "entries"), "--out", str(page)]) == 0
    assert "my own" in page.read_text()
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "docs/site"))
    site: Callable[..., set[Path]] = importlib.import_module("entry_board").write_pages
    [shown] = site(tmp_path / "site", tmp_path / "entries")
    assert "my own</td>" in shown.read_text()


def test_other_labels_than_the_frozen_ones_are_refused(
    labels: Path, results: Path, tmp_path: Path
) -> None:
    path = labels / "static_label" / "000000.txt"
    before = path.read_text()
    path.write_text(before.replace("0.00", "0.10", 1))
    with pytest.raises(DataError, match=r"1 of the 5 files .* static_label/000000\.txt"):
        made(results, labels, tmp_path / "out")
    path.write_text(before)
    (labels / "nocar").mkdir()
    (labels / "nocar" / "000009.txt").write_text(before)
    with pytest.raises(DataError, match=r"nocar/000009\.txt"):
        made(results, labels, tmp_path / "out")
    with pytest.raises(DataError, match="no such folder"):
        made(results, tmp_path / "nowhere", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_results_are_there_for_every_frame(labels: Path, results: Path, tmp_path: Path) -> None:
    (results / "000040.txt").unlink()
    with pytest.raises(DataError, match=r"1 of 4 result files are not here, the first 000040\.txt"):
        made(results, labels, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_only_results_are_entered_with_labels(labels: Path, results: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="--labels"):
        entered(Entered.DETECTOR, "oracle", tmp_path / "out", labels=labels, workers=0)
    with pytest.raises(ConfigurationError, match="--labels"):
        made(results, labels, tmp_path / "out", quick=True)


def test_what_is_frozen_is_names_hashes_and_intentions() -> None:
    frozen = frozen_labels()
    assert sum("annotation" not in name for name in frozen.files) == 600
    assert {len(content) for content in frozen.files.values()} == {16}
    assert {Path(name).stem for name in frozen.files} >= set(frozen.contested)
    assert frozen.digest == "52d3febf1759496b"
    # The procedural sets of the version are as they were.
    assert FROZEN == "version_1.json"
    digests = {name: one["digest"] for name, one in version_file()["sets"].items()}
    assert digests == {"all": "daac12326bc8b809", "contested": "44f3d2d717315aa2"}


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda found: found.pop("contested"), "contested"),
        (lambda found: found["files"].update({"nocar/000001.txt": "12ab"}), "nocar/000001.txt"),
        (lambda found: found["files"].update({"nocar/000001.txt": 7}), "files"),
        (lambda found: found["contested"].update({"000002": ["upwards"]}), "upwards"),
        (lambda found: found["contested"].update({"999999": ["left"]}), "999999"),
    ],
)
def test_damaged_frozen_labels_are_refused(
    change: Callable[[dict[str, Any]], object], named: str, tmp_path: Path
) -> None:
    path = tmp_path / "kitti_1.json"
    found = json.loads((Path(kitti_results.__file__).parent / "kitti_1.json").read_text())
    path.write_text(json.dumps(found))
    assert read_frozen_labels(path) == frozen_labels()
    change(found)
    path.write_text(json.dumps(found))
    with pytest.raises(DataError, match=named) as caught:
        read_frozen_labels(path)
    assert "kitti_1.json" in str(caught.value)


SHARED = Path(__file__).parents[3] / "shared" / "safety_scenarios"


@pytest.mark.skipif(not SHARED.is_dir(), reason="../shared/safety_scenarios is absent")
def test_the_authors_own_files_are_the_frozen_ones() -> None:
    scenes = frozen_labels().scenes(SHARED)
    assert len(scenes) == 600
    assert len(frozen_labels().of_contested(scenes)) == 168
    assert json.dumps(sorted(frozen_labels().truth(SHARED))) == json.dumps(
        sorted(scene.id for scene in scenes.labelled)
    )
