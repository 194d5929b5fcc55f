"""What is done to an entry."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.benchmark.protocol import (
    ADAPTIVE,
    DETECTORS,
    OPTICAL,
    PERTURBATION,
    QUIETER,
    VALIDATED,
    Entered,
    adaptive,
    adaptive_attack,
    is_white_box,
    settings_of,
    takes_gradients,
    unknowing_attacks,
)
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.registry import Kind, make


def by_name(kind: Entered, part: Any) -> dict[str, Any]:
    return {each.name: each for each in settings_of(kind, part, "all")}


def test_a_detector_is_attacked_by_its_own_gradients_where_it_has_any() -> None:
    assert is_white_box("dsgn")
    assert not is_white_box("oracle")
    assert [*by_name(Entered.DETECTOR, "oracle")] == ["unattacked", "transferred", "patch"]
    known = by_name(Entered.DETECTOR, "dsgn")
    assert [*known] == ["unattacked", "transferred", "patch", "white_box"]
    assert known["white_box"].parts["attack"] == known["transferred"].parts["attack"]["attack"]
    assert {each.against for each in known.values()} == {"", "unattacked"}


def test_an_adaptive_attack_has_more_steps_and_the_same_budget() -> None:
    """On contested scenes alone: own gradients twice, if there are any, and other detectors'."""
    known = {each.name: each for each in settings_of(Entered.DETECTOR, "dsgn", "contested")}
    assert [*known][-1] == ADAPTIVE
    assert known[ADAPTIVE].parts is not None
    attacks = known[ADAPTIVE].parts["attack"]["attacks"]
    assert attacks == adaptive_attack("dsgn")["attacks"]
    own, again, transferred = attacks
    assert own == again == transferred["attack"]
    assert transferred["of"] == "stereo_rcnn"
    listed, stronger = (make(Kind.ATTACK, part) for part in (PERTURBATION, own))
    assert stronger.budget == listed.budget
    assert stronger.steps > listed.steps
    # A black box is asked, and imitated by both of the package's detectors.
    assert [each["of"] for each in adaptive_attack("oracle")["attacks"]] == [*DETECTORS]


@pytest.mark.parametrize("inner", ["dsgn", {"name": "dsgn", "configuration": "small"}])
def test_a_defence_is_also_attacked_by_the_gradients_of_the_network_behind_it(inner: Any) -> None:
    """Where these do more harm than its own, the defence obfuscated its gradients."""
    defended = {"name": "defended", "detector": inner, "defence": "jpeg"}
    for part in (defended, {"name": "defended", "detector": defended}):
        own, again, behind, other = adaptive_attack(part)["attacks"]
        assert [own, again, other] == adaptive_attack(inner)["attacks"]
        assert behind == {"name": "transferred", "attack": own, "of": inner}
    # A wrapper without gradients of its own hides those of the network, too.
    attacked = {"name": "attacked", "detector": inner, "attack": {"name": "facula", "camera": 2}}
    assert adaptive_attack(attacked)["attacks"] == [behind, other]
    # What gives no gradients cannot be imitated by its own.
    blind = {"name": "defended", "detector": "oracle"}
    assert adaptive_attack(blind) == adaptive_attack("oracle")


def test_an_adaptive_attacker_of_validators_has_no_more_light_than_the_listed_one() -> None:
    settings = {
        each.name: each for each in settings_of(Entered.VALIDATOR, "thresholds", "contested")
    }
    assert len(settings) == 8
    for case in OPTICAL:
        under, listed = settings[adaptive(case)], settings[f"{case}{VALIDATED}"]
        assert (under.parts, under.against) == (listed.parts, listed.name)
        assert under.attempts == QUIETER[case]
        assert not listed.attempts
    listed_light, light = Facula(), [make(Kind.OPTICAL_ATTACK, part) for part in QUIETER["facula"]]
    for each in light:
        assert each.camera == listed_light.camera
        assert each.radius < min(listed_light.radius)
        assert each.strength <= listed_light.strength
    assert len({(each.centre, each.radius, each.strength) for each in light}) == 20
    plane = LidarSpoofing()
    planes = [make(Kind.OPTICAL_ATTACK, part) for part in QUIETER["lidar_spoofing"]]
    assert len({(each.distance, each.width, each.rays_lost) for each in planes}) == 12
    for each in planes:
        assert each.width <= plane.width
        assert each.height == plane.height
        assert min(each.distance) >= min(plane.distance)


@pytest.mark.parametrize(
    ("attack", "white"),
    [
        ("fgsm", True),
        ({"name": "strongest", "attacks": ["fgsm"]}, True),
        ({"name": "transferred", "attack": "fgsm", "of": "oracle"}, False),
        ({"name": "patch", "patch": "of a machine that is not here"}, False),
        ("facula", False),
        ("random_noise", False),
        ("of_a_package_that_is_not_installed", None),
    ],
)
def test_a_white_box_is_one_whose_own_gradients_are_taken(attack: Any, white: bool | None) -> None:
    assert takes_gradients(attack) is white


def test_an_attack_of_the_toolbox_climbs_gradients_or_asks_for_the_loss() -> None:
    pytest.importorskip("art")
    assert takes_gradients({"name": "art", "method": "BasicIterativeMethod"})


def test_gradients_are_transferred_from_another_detector() -> None:
    for part in (*DETECTORS, {"name": "dsgn", "weights": "my.safetensors"}, "mine"):
        attack = unknowing_attacks(part)["transferred"]
        assert attack is not None
        assert attack["of"] in DETECTORS
        assert attack["of"] != (part if isinstance(part, str) else part["name"])


def test_a_defence_is_attacked_as_what_stands_behind_it() -> None:
    plain = unknowing_attacks("dsgn")
    for part in (
        {"name": "defended", "detector": "dsgn", "defence": "jpeg"},
        {"name": "defended", "detector": {"name": "defended", "detector": {"name": "dsgn"}}},
    ):
        assert unknowing_attacks(part) == plain
    assert plain["transferred"]["of"] == "stereo_rcnn"


def test_an_attack_meets_both_detectors_with_and_without_it() -> None:
    settings = by_name(Entered.ATTACK, {"name": "facula", "camera": 3})
    assert [*settings] == ["dsgn", "dsgn attacked", "stereo_rcnn", "stereo_rcnn attacked"]
    assert settings["stereo_rcnn attacked"].against == "stereo_rcnn"
    assert "attack" not in settings["dsgn"].parts


def test_a_validator_stands_before_each_case_once() -> None:
    settings = by_name(Entered.VALIDATOR, "thresholds")
    assert len(settings) == 6
    for name, setting in settings.items():
        assert ("validator" in setting.parts) == name.endswith(" validated")
        if setting.against:
            own, other = dict(setting.parts), settings[setting.against].parts
            shipped = own.pop("validator")
            assert shipped["name"] == "thresholds"
            assert Path(shipped["thresholds"]).is_file()
            assert own == other


def test_a_fit_of_ones_own_takes_the_place_of_the_shipped_one() -> None:
    part = {"name": "likelihood", "model": "mine.json", "rate": 0.02}
    setting = by_name(Entered.VALIDATOR, part)["facula validated"]
    assert setting.parts["validator"] == part


def test_slips_are_reported() -> None:
    for kind in Entered:
        with pytest.raises(ConfigurationError, match=r"there is no .*'astarr'"):
            settings_of(kind, "astarr", "all")


def test_results_of_another_project(tmp_path: Path) -> None:
    part = {"name": "replayed", "detections": str(tmp_path)}
    with pytest.raises(DataError, match="avsec benchmark frames") as told:
        settings_of(Entered.DETECTOR, part, "all")
    assert str(tmp_path / "all" / "unattacked") in str(told.value)
    for name in ("unattacked", "patch"):
        (tmp_path / "all" / name).mkdir(parents=True)
    one, two = settings_of(Entered.DETECTOR, part, "all")
    assert (one.name, one.against, two.name, two.against) == (
        "unattacked", "", "patch", "unattacked",
    )  # fmt: skip
    assert two.parts is not None
    assert two.parts["detector"]["detections"] == str(tmp_path / "all" / "patch")
    assert two.parts["score_threshold"] == 0.3


def test_scores_without_bounds_are_cut_at_zero_attacked_or_not(tmp_path: Path) -> None:
    for name, score in (("unattacked", 2.5), ("patch", 0.4)):
        line = f"Car 0 0 0 0 0 50 50 1.5 1.6 4.0 0 1.65 20 0 {score}\n"
        folder = tmp_path / "all" / name
        folder.mkdir(parents=True)
        (folder / "000000.txt").write_text(line)
    part = {"name": "replayed", "detections": str(tmp_path)}
    for setting in settings_of(Entered.DETECTOR, part, "all"):
        assert setting.parts is not None
        assert setting.parts["score_threshold"] == 0.0


@pytest.mark.parametrize("more", [{}, {"detections": 3}, {"detections": "x", "label": "mine"}])
def test_results_that_are_named_wrongly(more: dict[str, Any]) -> None:
    with pytest.raises((ConfigurationError, DataError)):
        settings_of(Entered.DETECTOR, {"name": "replayed", **more}, "all")
