"""The spread of patches as cells: which there are, what is stored, and that it can be read."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from avsec_gym.attacks.patch_files import Patch, save_patch
from avsec_gym.experiments.chapter5 import patch_spreads
from avsec_gym.experiments.chapter5.feature_spread import FeatureSpread, LayerSpread, SpreadExtent
from avsec_gym.experiments.chapter5.patch_spreads import PatchSpreads, spread_cells, spread_rows
from avsec_gym.experiments.json_rows import row_json
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.runs.experiment import Configuration

WITHOUT = "dsgn_without_pyramid"


def asked(monkeypatch: pytest.MonkeyPatch, scenes: int, **options: Any) -> list[dict[str, Any]]:
    monkeypatch.setattr(patch_spreads, "scenes_of", lambda configuration: range(scenes))
    return [cell.arguments for cell in spread_cells(Configuration(options=options))]


def test_cells_are_of_what_is_there(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    folder = str(tmp_path)
    bare = asked(monkeypatch, 2, patches=folder)
    assert {(arguments["patch"], arguments["images"]) for arguments in bare} == {
        ("noise", "noise"),
        ("noise", "scenes"),
    }
    assert {arguments["detector"] for arguments in bare} == {"dsgn", "stereo_rcnn"}
    assert {arguments["images"] for arguments in asked(monkeypatch, 1, patches=folder)} == {"noise"}
    save_patch(tmp_path / "joint.safetensors", Patch.grey())
    save_patch(tmp_path / "dsgn.safetensors", Patch.grey())
    full = asked(monkeypatch, 2, patches=folder, dsgn_without_pyramid="somewhere")
    patches = {(arguments["detector"], arguments["patch"]) for arguments in full}
    assert patches == {
        *((name, kind) for name in ("dsgn", "stereo_rcnn", WITHOUT) for kind in ("joint", "noise")),
        ("dsgn", "patch"),
    }


def test_what_is_stored_can_be_read_in_order(
    made: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The layers of the thesis from shallow to deep, whatever the order in which rows are kept."""

    def spread(self: PatchSpreads, detector: str, patch: str, images: str) -> FeatureSpread:
        names = ("conv1", "branch4", "fusion1") if detector == "dsgn" else ("conv1", "maxpool1")
        layers = [
            LayerSpread(
                name,
                np.zeros((2, 2)),
                SpreadExtent(4.0, 0.1, 0.2, 10.0 * depth, 20.0 * depth, 99.0),
            )
            for depth, name in enumerate(names, start=1)
        ]
        return FeatureSpread(np.zeros((2, 2, 3)), 38.0, tuple(layers))

    monkeypatch.setattr(PatchSpreads, "spread", spread)
    work, results = PatchSpreads(Configuration()), made.MadeResults()
    for detector in ("stereo_rcnn", "dsgn"):
        results.numbers += reversed(work(detector, "noise", "noise").measurements)
    rows = spread_rows(results)
    assert [(row.detector, row.layer) for row in rows] == [
        ("dsgn", "conv1"),
        ("dsgn", "branch4"),
        ("dsgn", "fusion1"),
        ("stereo_rcnn", "conv1"),
        ("stereo_rcnn", "maxpool1"),
    ]
    assert list(row_json(rows[0])) == [
        *("detector", "patch", "images", "layer", "patch_radius"),
        *("cell", "share", "share_absolute", "radius", "radius_absolute", "reach"),
    ]
    assert [row.extent.radius for row in rows] == [10, 20, 30, 10, 20]
    assert {row.patch_radius for row in rows} == {38}
    assert spread_rows(made.MadeResults()) == []


@pytest.mark.slow
def test_scenes_of_one_size_are_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    from avsec_gym.frame import SensorFrame
    from avsec_gym.rig import kitti_rig
    from avsec_gym.scenario.frame_scenes import FrameScenes
    from avsec_gym.scenario.scene import Scene
    from avsec_gym.scenario.scene_set import SceneSet

    random = np.random.default_rng(0)
    odd = {1: (370, 1224)}

    class Data:
        folder = Path("made", "training")

        def frame(self, id: str) -> SensorFrame:
            size = odd.get(int(id), (375, 1242))
            image = random.integers(0, 256, (*size, 3), np.uint8)
            return SensorFrame(id, kitti_rig().calibration, {2: image, 3: image})

    names = [f"{number:06d}" for number in range(3)]
    from avsec_gym.boxes import Boxes3D

    scenes = SceneSet("made", tuple(Scene(name, Boxes3D.empty()) for name in names))
    frames = FrameScenes(scenes, dict.fromkeys(names, Data()))  # type: ignore[arg-type]
    monkeypatch.setattr(patch_spreads, "scenes_of", lambda configuration: frames)
    monkeypatch.setattr(patch_spreads, "trained_detector", lambda name, options: DsgnDetector())
    spread = PatchSpreads(Configuration()).spread("dsgn", "noise", "scenes")
    assert spread.layers[0].layer == "conv1"
    assert spread.image.shape == (240, 240, 3)
