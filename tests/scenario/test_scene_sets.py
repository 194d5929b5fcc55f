"""Sets of scenes from folders: flags, groups, seeds, and what is refused."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.labels import read_labels
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.commonroad import write_commonroad
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import (
    DYNAMIC_HIGHWAY,
    DYNAMIC_STREET,
    STATIC_STREET,
    WITHOUT_CARS,
    flagged,
    label_folder,
    labelled_scenarios,
    procedural_scenes,
    scene_set,
)


def line(z: float, category: str = "Car") -> str:
    return f"{category} 0.00 0 0.00 1.00 1.00 9.00 9.00 1.50 1.60 4.00 0.00 1.65 {z:.2f} -1.57\n"


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


@pytest.fixture
def labelled(tmp_path: Path) -> Path:
    """A tiny folder in the layout of the labelled scenarios."""
    root = tmp_path / "scenarios"
    write(root / "static_label/000004.txt", line(10) + line(20))
    write(root / "dynamic_label/000003.txt", line(10) + line(20) + line(30) + line(40))
    write(root / "dynamic_annotation/000003.txt", "n\n0\n1\n-1\n")
    write(root / "road_dynamic_label/000002.txt", line(10) + line(20) + line(30))
    write(root / "road_dynamic_annotation/000002.txt", "1\n1")
    write(root / "nocar/000001.txt", line(10, "Pedestrian"))
    return root


def test_groups_and_road_types(labelled: Path) -> None:
    scenes = labelled_scenarios(labelled)
    assert [(s.id, s.group, s.road_type, s.number) for s in scenes.scenes] == [
        ("000001", WITHOUT_CARS, RoadType.STREET, 1),
        ("000002", DYNAMIC_HIGHWAY, RoadType.HIGHWAY, 2),
        ("000003", DYNAMIC_STREET, RoadType.STREET, 3),
        ("000004", STATIC_STREET, RoadType.STREET, 4),
    ]
    assert scenes.name == "scenarios"


def test_flags(labelled: Path) -> None:
    """n is no obstacle, 0 stands, 1 and -1 move along the label's heading."""
    scene = labelled_scenarios(labelled).scenes[2]
    assert scene.boxes.location[:, 2].tolist() == [20.0, 30.0, 40.0]
    assert scene.boxes.moving is not None
    assert scene.boxes.moving.tolist() == [False, True, True]
    heading = scene.truth().polygons(10)[2].centroid.x - 40
    assert heading == pytest.approx(scene.speeds[2], rel=1e-3)


def test_a_missing_flag_is_n_and_reported(labelled: Path) -> None:
    scenes = labelled_scenarios(labelled)
    assert scenes.scenes[1].boxes.location[:, 2].tolist() == [10.0, 20.0]
    (remark,) = scenes.remarks
    assert "road_dynamic_annotation/000002.txt: 2 flags for 3 labels" in remark


def test_a_surplus_flag_is_dropped_and_reported(labelled: Path) -> None:
    write(labelled / "road_dynamic_annotation/000002.txt", "n\n1\n0\n1\n1\n")
    scenes = labelled_scenarios(labelled)
    assert scenes.scenes[1].boxes.location[:, 2].tolist() == [20.0, 30.0]
    assert "5 flags for 3 labels" in scenes.remarks[0]


def test_flags_count_lines_of_every_category(labelled: Path) -> None:
    """Also DontCare lines, which are no objects, have their flag."""
    care = "DontCare -1 -1 -10 1.00 1.00 9.00 9.00 -1 -1 -1 -1000 -1000 -1000 -10\n"
    write(labelled / "dynamic_label/000003.txt", care + line(20) + line(30))
    write(labelled / "dynamic_annotation/000003.txt", "1\n0\n1\n")
    scene = labelled_scenarios(labelled).scenes[2]
    assert scene.boxes.location[:, 2].tolist() == [20.0, 30.0]
    assert scene.boxes.moving is not None
    assert scene.boxes.moving.tolist() == [False, True]


@pytest.mark.parametrize("ending", ["", "\n", "\r\n", "\n\n \n"])
def test_line_ends_do_not_matter(labelled: Path, ending: str) -> None:
    boxes = read_labels(labelled / "dynamic_label/000003.txt")
    flags = labelled / "flags.txt"
    flags.write_bytes(("n\r\n0\r\n 1 \n-1" + ending).encode())
    kept, remark = flagged(boxes, flags)
    assert (len(kept), remark) == (3, None)


@pytest.mark.parametrize(
    ("text", "number"), [("n\n0\n2\n1\n", 3), ("n\n\n1\n1\n", 2), ("+1\n", 1), ("n\n0\n1\n1\nx", 5)]
)
def test_bad_flags_name_file_and_line(labelled: Path, text: str, number: int) -> None:
    path = write(labelled / "dynamic_annotation/000003.txt", text)
    scenes = labelled_scenarios(labelled)
    assert scenes.skipped == 1
    assert "000003" not in {scene.id for scene in scenes.scenes}
    assert f"{path}:{number}: " in scenes.remarks[-1]


def test_unreadable_flags(labelled: Path) -> None:
    path = labelled / "dynamic_annotation/000003.txt"
    path.write_bytes(b"n\n\xff\xfe\n")
    assert "000003.txt" in labelled_scenarios(labelled).remarks[-1]
    path.unlink()
    assert "needs a flag file" in labelled_scenarios(labelled).remarks[-1]


def test_a_broken_label_names_file_and_line(labelled: Path) -> None:
    write(labelled / "static_label/000004.txt", line(10) + "Car 0 0\n")
    assert "static_label/000004.txt:2: " in labelled_scenarios(labelled).remarks[-1]


def test_files_that_are_no_frames_are_reported(tmp_path: Path) -> None:
    for name in ("000001", "frame_17"):
        write(tmp_path / f"{name}.txt", line(10))
    scenes = label_folder(tmp_path)
    assert (len(scenes), scenes.skipped) == (1, 0)
    assert "frame_17.txt" in scenes.remarks[0]


def test_a_set_of_broken_files_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "000001.txt", "Car 0 0\n")
    with pytest.raises(DataError, match=r"000001\.txt:1: "):
        label_folder(tmp_path)


def test_parts_may_be_absent_but_not_all(labelled: Path, tmp_path: Path) -> None:
    only = tmp_path / "only"
    only.mkdir()
    (labelled / "nocar").rename(only / "nocar")
    assert len(labelled_scenarios(only)) == 1
    assert len(labelled_scenarios(labelled)) == 3
    with pytest.raises(DataError, match="none of the labelled"):
        labelled_scenarios(tmp_path)


def test_speeds_do_not_depend_on_other_scenes(labelled: Path) -> None:
    every = {scene.id: scene.speeds for scene in labelled_scenarios(labelled, seed=5).scenes}
    write(labelled / "dynamic_label/000000.txt", line(10) * 5)
    write(labelled / "dynamic_annotation/000000.txt", "1\n" * 5)
    for scene in labelled_scenarios(labelled, seed=5).scenes[1:]:
        np.testing.assert_array_equal(scene.speeds, every[scene.id])
    other = {scene.id: scene.speeds for scene in labelled_scenarios(labelled, seed=6).scenes}
    assert other["000003"][1] != every["000003"][1]


def test_a_folder_of_labels(tmp_path: Path) -> None:
    for i in (3, 1, 2):
        write(tmp_path / f"labels/00000{i}.txt", line(10 + i))
    write(tmp_path / "labels/readme.txt", "no label")
    scenes = scene_set(tmp_path / "labels")
    assert [scene.id for scene in scenes.scenes] == ["000001", "000002", "000003"]
    assert not any(scene.speeds.any() for scene in scenes.scenes)
    assert {scene.road_type for scene in scenes.scenes} == {RoadType.STREET}
    write(tmp_path / "flags/000002.txt", "1\n")
    moving = [bool(scene.speeds.any()) for scene in scene_set(tmp_path / "labels").scenes]
    assert moving == [False, True, False]
    assert moving == [bool(s.speeds.any()) for s in scene_set(tmp_path).scenes]
    assert len(scene_set(tmp_path / "labels", count=2)) == 2


def test_an_empty_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no label file"):
        scene_set(tmp_path)
    with pytest.raises(DataError, match="no label file"):
        label_folder(tmp_path)


def test_an_empty_label_file_is_a_scene_without_objects(tmp_path: Path) -> None:
    write(tmp_path / "000001.txt", "")
    (scene,) = scene_set(tmp_path).scenes
    assert len(scene.truth()) == 0


def test_a_list_of_frames(tmp_path: Path) -> None:
    for i in range(4):
        write(tmp_path / f"kitti/training/label_2/00000{i}.txt", line(10 + i))
    frames = write(tmp_path / "val.txt", "000002\n000000\n")
    scenes = scene_set(frames, kitti=tmp_path / "kitti")
    assert [scene.id for scene in scenes.scenes] == ["000002", "000000"]
    assert len(scene_set(frames, kitti=tmp_path / "kitti", count=1)) == 1
    with pytest.raises(ConfigurationError, match="beside --kitti"):
        scene_set(frames)
    write(frames, "000002\n000009\n")
    scenes = scene_set(frames, kitti=tmp_path / "kitti")
    assert (len(scenes), scenes.skipped) == (1, 1)
    assert "000009" in scenes.remarks[0]


@pytest.mark.parametrize("name", ["LAYOUTS", "layout", "layuots"])
def test_a_mistyped_name_is_suggested(name: str) -> None:
    with pytest.raises(ConfigurationError, match='Did you mean "layouts"'):
        scene_set(name)


@pytest.mark.parametrize("name", ["no_such_folder", "/no/such/folder", "my/layouts"])
def test_what_is_not_there_is_missing_data(name: str) -> None:
    with pytest.raises(DataError, match="'layouts'") as error:
        scene_set(name)
    assert error.value.path == name


def test_procedural_scenes_are_seeded() -> None:
    one, two = scene_set("layouts", count=5), scene_set("layouts", count=9)
    assert digest(one) == digest(two.limited(5))
    assert digest(one) != digest(scene_set("layouts", count=5, seed=1))
    assert len(procedural_scenes(3)) == 3
    assert {scene.seed for scene in scene_set("layouts", count=3, seed=7).scenes} == {7}


def digest(scenes: SceneSet) -> str:
    code = hashlib.sha256()
    for scene in scenes.scenes:
        code.update(f"{scene.id} {scene.group} {scene.road_type}".encode())
        for array in (scene.boxes.poses, scene.boxes.dimensions, scene.speeds):
            code.update(np.ascontiguousarray(array).tobytes())
    return code.hexdigest()


def test_another_process_makes_the_same_scenes(labelled: Path) -> None:
    program = (
        "import sys; from tests.scenario.test_scene_sets import digest;"
        "from avsec_gym.scenario.scene_sets import scene_set;"
        "print(digest(scene_set(sys.argv[1], seed=4)), digest(scene_set('layouts', count=7)))"
    )
    output = subprocess.run(
        [sys.executable, "-c", program, str(labelled)],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parents[2],
    ).stdout.split()
    assert output == [
        digest(scene_set(labelled, seed=4)),
        digest(scene_set("layouts", count=7)),
    ]


def test_the_600_scenarios(shared: Path) -> None:
    scenes = scene_set(shared / "safety_scenarios")
    assert Counter(scene.group for scene in scenes.scenes) == {
        STATIC_STREET: 319,
        DYNAMIC_STREET: 69,
        DYNAMIC_HIGHWAY: 168,
        WITHOUT_CARS: 44,
    }
    ids = [scene.id for scene in scenes.scenes]
    assert ids == sorted(set(ids))
    assert [remark.split(":")[0] for remark in scenes.remarks] == [
        "dynamic_annotation/000329.txt",
        "dynamic_annotation/000336.txt",
        "road_dynamic_annotation/000359.txt",
    ]
    for scene in scenes.scenes:
        movers = scene.speeds[scene.speeds > 0]
        low, high = (11, 13) if scene.road_type is RoadType.HIGHWAY else (6, 8)
        assert ((movers >= low) & (movers <= high)).all()
        assert len(set(movers)) == len(movers)
        if scene.group in (STATIC_STREET, WITHOUT_CARS):
            assert not len(movers)
    assert sum(bool(s.speeds.any()) for s in scenes.scenes) > 200


def test_labels_of_the_600_are_those_of_kitti(shared: Path) -> None:
    """What --kitti and --scenarios name are the same frames."""
    scenes = scene_set(shared / "safety_scenarios").scenes
    for scene in [each for each in scenes if each.group == STATIC_STREET][::40]:
        theirs = read_labels(shared / f"kitti/object/training/label_2/{scene.id}.txt")
        np.testing.assert_allclose(scene.boxes.location, theirs.location)


def test_commonroad_files(tmp_path: Path) -> None:
    for name in ("b", "a"):
        scene = procedural_scenes(1, seed=3).scenes[0]
        write_commonroad(replace(scene.problem(Intention.LEFT), id=name), tmp_path / f"{name}.xml")
    scenes = scene_set(tmp_path)
    assert [scene.id for scene in scenes.scenes] == ["a", "b"]
    assert (scenes.skipped, scenes.remarks) == (0, ())
    with pytest.raises(ConfigurationError, match="labelled objects"):
        _ = scenes.labelled
    (tmp_path / "b.xml").write_text("<commonRoad>")
    scenes = scene_set(tmp_path)
    assert (len(scenes), scenes.skipped) == (1, 1)
    assert "b.xml" in scenes.remarks[0]
    (tmp_path / "a.xml").write_text("")
    with pytest.raises(DataError, match=r"a\.xml:1: "):
        scene_set(tmp_path)
