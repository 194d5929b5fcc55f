"""`PatchAttack` and the files of patches."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from safetensors.torch import save_file

from avsec_gym.attacks.attack import Attack, Victim
from avsec_gym.attacks.patch import PatchAttack
from avsec_gym.attacks.patch_files import (
    Patch,
    PatchCard,
    load_patch,
    patch_of,
    save_patch,
    shipped_patch,
)
from avsec_gym.attacks.patch_names import check_patch_name, patch_names
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.recorded import Oracle
from avsec_gym.perception.weights.weights_hash import weights_hash
from avsec_gym.registry import Kind, make
from avsec_gym.rig import kitti_rig
from avsec_gym.scenario.intention import Intention


@pytest.fixture
def frame() -> SensorFrame:
    draw = np.random.default_rng(0)
    images = {camera: draw.integers(0, 256, (375, 1242, 3), np.uint8) for camera in (2, 3)}
    return SensorFrame("000000", kitti_rig().calibration, images)


def victim(intention: Intention | None = None) -> Victim:
    return Victim(Oracle(), Boxes3D.empty(), intention)


def test_attacks_keep_their_budget_and_repeat_themselves(frame: SensorFrame) -> None:
    attack = PatchAttack("noise")
    assert isinstance(attack, Attack)
    for seed in range(5):
        attacked = attack.attack(frame, victim(), seed)
        assert not attack.budget.exceeded_by(frame, attacked)
        again = PatchAttack(Patch.noise()).attack(frame, victim(), seed)
        for camera in (2, 3):
            assert attacked.image(camera).dtype == np.float32
            assert (attacked.image(camera) == again.image(camera)).all()
            assert (attacked.image(camera) != frame.image(camera)).any()
    assert not PatchAttack("noise", radius=20).budget.exceeded_by(
        frame, PatchAttack("noise", radius=20).attack(frame, victim())
    )
    assert PatchAttack("noise", radius=20).budget.exceeded_by(frame, attacked)


def test_a_patch_for_other_weights_is_reported_once(
    frame: SensorFrame, caplog: pytest.LogCaptureFixture
) -> None:
    class Learned(Oracle):
        name = "learned"
        network = torch.nn.Linear(2, 2)

    detector = Learned()
    kinds = {"old": "0" * 64, "today": weights_hash(detector), "another": None}
    reported = {}
    for kind, digest in kinds.items():
        card = PatchCard({"other" if kind == "another" else "learned": digest})
        attack = PatchAttack(replace(Patch.noise(), card=card))
        caplog.clear()
        for seed in range(2):
            attack.attack(frame, Victim(detector, Boxes3D.empty(), None), seed)
        reported[kind] = len(caplog.messages)
    assert reported == {"old": 1, "today": 0, "another": 0}


def test_the_place_is_the_one_that_is_told(frame: SensorFrame) -> None:
    attack = PatchAttack("grey", placement="specific")
    place = attack.placed(frame, victim(Intention.RIGHT), 3)
    assert place.intention(1242) == Intention.RIGHT
    attacked = attack.attack(frame, victim(Intention.RIGHT), 3)
    for camera, u in ((2, place.u), (3, place.u - place.disparity)):
        assert (attacked.image(camera)[round(place.v), round(u)] == 127.5).all()
    with pytest.raises(ConfigurationError, match="intention"):
        attack.attack(frame, victim(), 3)
    random = PatchAttack("grey")
    assert random.placed(frame, victim(Intention.LEFT), 3) == random.placed(frame, victim(), 3)


def test_impossible_attacks_are_errors(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="somewhere"):
        PatchAttack("grey", placement="somewhere")  # type: ignore[arg-type]
    with pytest.raises(ConfigurationError, match="radius"):
        PatchAttack("grey", radius=0)
    with pytest.raises(DataError, match=r"lost\.safetensors: There is no such file"):
        PatchAttack(tmp_path / "lost.safetensors")


@pytest.mark.parametrize("name", ["dsgn", "stereo_rcnn", "joint"])
def test_patches_of_the_package_have_names(name: str) -> None:
    attack = make(Kind.ATTACK, {"name": "patch", "patch": name})
    assert torch.equal(attack.patch.pixels, load_patch(shipped_patch(name)).pixels)
    with pytest.raises(ConfigurationError, match=f'Did you mean "{name}"'):
        PatchAttack(f"{name}x")


def test_every_name_of_a_patch_stands_for_one(tmp_path: Path) -> None:
    for name in patch_names():
        check_patch_name(name)
        assert patch_of(name).pixels.shape == (3, 76, 76)
    with pytest.raises(DataError, match=r"This is no file.*grey, noise"):
        patch_of(tmp_path)
    with pytest.raises(ConfigurationError, match="one of grey, noise, dsgn, joint"):
        patch_of(5)  # type: ignore[arg-type]


def test_controls_are_patches_of_the_same_size() -> None:
    grey, noise = Patch.grey(), Patch.noise(1)
    assert grey.pixels.shape == noise.pixels.shape == (3, 76, 76)
    assert grey.pixels.std() == 0
    assert noise.pixels.std() == pytest.approx(255 / np.sqrt(12), rel=0.02)
    assert torch.equal(noise.pixels, Patch.noise(1).pixels)
    assert not torch.equal(noise.pixels, Patch.noise(2).pixels)


def test_a_saved_patch_comes_back(tmp_path: Path) -> None:
    card = PatchCard({"dsgn": "abc"}, losses={"last_epoch": {"dsgn": 1.5}}, epochs=3)
    path = tmp_path / "patch.safetensors"
    saved = save_patch(path, Patch(Patch.noise(3).pixels, 38.0, card))
    loaded = load_patch(path)
    assert torch.equal(loaded.pixels, saved.pixels)
    assert loaded.radius == 38.0
    assert loaded.card == saved.card
    picture = cv2.imread(str(path.with_suffix(".png")))[..., ::-1]
    assert picture.shape == (304, 304, 3)
    assert (picture[0, 0] == 255).all(), "white around the disc"
    assert picture[152, 152] == pytest.approx(saved.pixels[:, 38, 38].numpy(), abs=0.5)
    assert PatchAttack(path).budget == PatchAttack(saved).budget


def test_broken_files_name_themselves(tmp_path: Path) -> None:
    path = tmp_path / "patch.safetensors"
    save_patch(path, Patch.noise())
    whole, card = path.read_bytes(), path.with_suffix(".json")
    path.write_bytes(whole[:-7])
    with pytest.raises(DataError, match=r"patch\.safetensors: The file is no sound"):
        load_patch(path)
    save_patch(tmp_path / "other.safetensors", Patch.noise(9))
    path.write_bytes((tmp_path / "other.safetensors").read_bytes())
    with pytest.raises(DataError, match="not the one of its card"):
        load_patch(path)
    card.write_text("[1]")
    with pytest.raises(DataError, match="else than a JSON object"):
        load_patch(path)
    card.write_text(json.dumps({"epochs": 3}))
    path.write_bytes(whole)
    with pytest.raises(DataError, match="not the one of its card"):
        load_patch(path)
    card.unlink()
    assert load_patch(path).card is None


@pytest.mark.parametrize(
    "parts",
    [
        {"radius": torch.tensor(75.0)},
        {"pixels": torch.zeros(3, 8, 8)},
        {"pixels": torch.zeros(3, 8, 8, dtype=torch.uint8), "radius": torch.tensor(75.0)},
        {"pixels": torch.zeros(3, 8, 8), "radius": torch.tensor([75.0])},
    ],
)
def test_files_without_pixels_and_a_radius_are_no_patch(
    parts: dict[str, torch.Tensor], tmp_path: Path
) -> None:
    path = tmp_path / "patch.safetensors"
    save_file(parts, path)
    with pytest.raises(DataError, match=r"patch\.safetensors: This is no patch: one has pixels"):
        load_patch(path)


@pytest.mark.parametrize(
    "pixels", [torch.zeros(3, 4, 5), torch.full((3, 4, 4), np.nan), torch.full((3, 4, 4), 300.0)]
)
def test_pixels_that_are_no_patch(pixels: torch.Tensor) -> None:
    with pytest.raises(ConfigurationError):
        Patch(pixels)
