"""Labelled stereo frames as scenes: their road types, their moving objects, what is missing."""

from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.frame_scenes import (
    SUITES,
    check_frame_scenes,
    frame_scenes,
    frame_scenes_of,
    sensors_of,
)
from avsec_gym.world import export
from avsec_gym.world.export import LayoutFrames, default_suites

LABEL = "Car 0.00 0 0.00 1.00 1.00 9.00 9.00 1.50 1.60 4.00 0.00 1.65 20.00 -1.57\n"


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Two frames with both images, a third without the right one."""
    for folder in ("label_2", "image_2", "image_3", "moving"):
        (tmp_path / "training" / folder).mkdir(parents=True)
    for id in ("000000", "000001", "000002"):
        (tmp_path / "training" / "label_2" / f"{id}.txt").write_text(LABEL)
        for camera in (2, 3)[: 1 if id == "000002" else 2]:
            (tmp_path / "training" / f"image_{camera}" / f"{id}.png").touch()
    return tmp_path


def test_road_type_and_moving_objects_come_from_the_files_beside_the_labels(root: Path) -> None:
    (root / "training" / "road_type.csv").write_text("img_name,label\n000001.png,0\n")
    (root / "training" / "moving" / "000001.txt").write_text("1\n")
    frames = frame_scenes(root)
    standing, driving = frames.scenes.labelled
    assert [standing.id, driving.id] == ["000000", "000001"]
    assert standing.road_type is RoadType.STREET, "unlisted frames are streets"
    assert driving.road_type is RoadType.HIGHWAY
    assert standing.boxes.moving is None or not standing.boxes.moving.any()
    assert driving.boxes.moving is not None
    assert driving.boxes.moving.tolist() == [True]


def test_count_takes_the_first(root: Path) -> None:
    assert [scene.id for scene in frame_scenes(root, count=1).scenes.labelled] == ["000000"]


def test_no_frame_with_both_images_is_said(root: Path) -> None:
    for path in (root / "training" / "image_3").iterdir():
        path.unlink()
    with pytest.raises(DataError, match="No frame here has labels and both images"):
        frame_scenes(root)


def test_a_source_that_is_no_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises((ConfigurationError, DataError), match="nowhere"):
        frame_scenes(tmp_path / "nowhere")


def test_the_authors_scenarios_say_what_is_real_and_the_folders_what_is_seen(
    root: Path, tmp_path: Path
) -> None:
    scenarios = tmp_path / "scenarios"
    for folder in ("road_dynamic_label", "road_dynamic_annotation"):
        (scenarios / folder).mkdir(parents=True)
    for id in ("000001", "000007"):
        (scenarios / "road_dynamic_label" / f"{id}.txt").write_text(LABEL + LABEL)
        (scenarios / "road_dynamic_annotation" / f"{id}.txt").write_text("1\n0\n")
    frames = frame_scenes([root], scenarios=scenarios)
    (scene,) = frames.scenes.labelled
    assert (scene.id, scene.road_type, len(scene.boxes)) == ("000001", RoadType.HIGHWAY, 2)
    assert len(frames.labels(scene)) == 1
    assert frames.scenes.remarks == ("1 of 2 scenarios have no images",)
    assert frames.disparity(scene) is None


def test_a_suite_of_a_part_of_the_assets_stands_beside_the_usual_one(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: dict[str, LayoutFrames] = {}

    def cached(name: str, recipe: LayoutFrames) -> Path:
        made[name] = recipe
        return root

    monkeypatch.setattr(export, "cached", cached)
    monkeypatch.setattr(export, "world_frames", lambda name: pytest.fail(f"all assets: {name}"))
    for suite in SUITES:
        judging = {"source": suite, "assets": "judge"}
        check_frame_scenes(judging)
        assert sensors_of(judging) == sensors_of(suite)
        assert len(frame_scenes_of(judging)) == 2
    assert list(made) == [f"{suite}-judge" for suite in SUITES]
    assert {recipe.assets for recipe in made.values()} == {"judge"}
    # The layouts are those of the usual suite.
    frames = {suite: default_suites.DEFAULT_FRAMES[suite] for suite in SUITES}
    assert [len(recipe) for recipe in made.values()] == list(frames.values())
    assert {(recipe.seed, recipe.previous) for recipe in made.values()} == {(0, 0)}


def test_assets_of_what_is_made_already_are_refused(root: Path) -> None:
    for refusing in (check_frame_scenes, lambda what: frame_scenes(**what)):
        for source in (str(root), "kitti_contested"):
            with pytest.raises(ConfigurationError, match="assets is for the suites street"):
                refusing({"source": source, "assets": "judge"})
        with pytest.raises(ConfigurationError, match=r"part of the assets 'jugde'.*judge"):
            refusing({"source": "mixed", "assets": "jugde"})
    assert len(frame_scenes(root, assets="all")) == 2
