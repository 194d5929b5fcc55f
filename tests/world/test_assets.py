"""No asset of the judging part is seen in training: rule, and scenes."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from avsec_gym.road_type import RoadType
from avsec_gym.world import assets, built_scene
from avsec_gym.world.assets import Assets, members, part_of, seed_of, shared, variants
from avsec_gym.world.drives import drive_scenes
from avsec_gym.world.layouts import generate_layout
from avsec_gym.world.models.buildings import KINDS
from avsec_gym.world.models.furniture import variants as furniture
from avsec_gym.world.models.plants import SPECIES, VARIANTS
from avsec_gym.world.models.vehicles import vehicle
from avsec_gym.world.models.vehicles.designs import body_designs
from avsec_gym.world.posed_scenes import posed_scene_of_layout
from avsec_gym.world.scenery import composition, frontage, plot
from avsec_gym.world.site import Style
from avsec_gym.world.textures.chosen import chosen_texture, family_sizes
from avsec_gym.world.textures.library import texture_library

PARTS = (Assets.TRAIN, Assets.JUDGE)


def test_a_third_of_the_seeds_judges() -> None:
    judging = np.mean([part_of(seed) == Assets.JUDGE for seed in range(3000)])
    assert abs(judging - 1 / 3) < 0.03


@pytest.mark.parametrize("part", PARTS)
def test_a_seed_of_a_part_is_of_that_part_and_stays_itself(part: Assets) -> None:
    seeds = [seed_of(part, seed) for seed in range(2**31 - 300, 2**31)]
    assert all(part_of(seed) == part and 0 <= seed < 2**31 for seed in seeds)
    assert [seed_of(part, seed) for seed in seeds] == seeds
    assert [seed_of(Assets.ALL, seed) for seed in (0, 5)] == [0, 5]


@pytest.mark.parametrize("count", range(2, 50))
def test_families_are_split_in_thirds_without_a_rest(count: int) -> None:
    train, judge = (set(variants("texture/brick", count, part)) for part in PARTS)
    assert train
    assert judge
    assert not train & judge
    assert train | judge == set(variants("texture/brick", count, Assets.ALL)) == set(range(count))
    assert abs(len(judge) - count / 3) <= 0.5 or count == 2


def test_the_rule_is_the_same_in_another_process() -> None:
    code = (
        "from avsec_gym.world.assets import *; "
        "print(variants('plant/lime', 6, Assets.JUDGE), members('a', ('x', 'y', 'z'), Assets.JUDGE)"
        ", [part_of(i).value for i in range(12)])"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    here = (
        variants("plant/lime", 6, Assets.JUDGE),
        members("a", ("x", "y", "z"), Assets.JUDGE),
        [part_of(i).value for i in range(12)],
    )
    assert told.stdout.split() == " ".join(map(str, here)).split()


def test_every_kind_of_asset_has_both_parts() -> None:
    families = {f"texture/{name}": count for name, count in family_sizes().items()}
    families |= {f"building/{kind}": frontage.HOUSES for kind in KINDS}
    families |= {f"plant/{kind}": VARIANTS for kind in SPECIES}
    families |= {f"place/{style}": composition.MANNERS for style in Style}
    for family, count in families.items():
        if not shared(family.partition("/")[2]):
            assert count >= 2, f"{family} cannot be split"


def test_body_designs_are_split_within_their_kinds() -> None:
    train, judge = (body_designs(None, part) for part in PARTS)
    names = {design.name for design in body_designs()}
    assert {design.name for design in train}.isdisjoint(design.name for design in judge)
    assert {design.name for design in (*train, *judge)} == names
    # Where there are several of a kind, both parts have some.
    kinds = {design.name: design.kind for design in body_designs()}
    several = {kind for kind in kinds.values() if list(kinds.values()).count(kind) > 1}
    assert several <= {design.kind for design in train} & {design.kind for design in judge}
    for part in PARTS:
        assert len(body_designs("Car", part)) > 5
        assert len(body_designs("Van", part)) > 1


def test_a_texture_gives_way_to_one_like_it() -> None:
    for part in PARTS:
        bricks = {chosen_texture(f"brick/{i}", part, 7) for i in range(5)}
        assert bricks == {f"brick/{i}" for i in variants("texture/brick", 5, part)}
        feet = [chosen_texture(f"stucco_foot/{i}", part, 7) for i in range(4)]
        walls = [chosen_texture(f"stucco/{i}", part, 7) for i in range(4)]
        assert [foot.split("/")[1] for foot in feet] == [wall.split("/")[1] for wall in walls]
        assert chosen_texture("slate", part, 7) in texture_library().names
        assert chosen_texture("plate/3", part, 7) == "plate/3"


class Used:
    """The names of all assets that scenes of a part are made of."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.names: set[str] = set()
        self._patch(monkeypatch)

    def _patch(self, monkeypatch: pytest.MonkeyPatch) -> None:
        def draw(rng: np.random.Generator, family: str, count: int, part: Assets) -> int:
            number = assets.draw_variant(rng, family, count, part)
            if not shared(family.partition("/")[2]):
                self.names.add(f"{family}/{number}")
            return number

        for module in (plot, furniture):
            monkeypatch.setattr(module, "draw_variant", draw)
        choose = vehicle.choose_design

        def body(*arguments):  # type: ignore[no-untyped-def]
            design = choose(*arguments)
            self.names.add(f"vehicle/{design.name}")
            return design

        monkeypatch.setattr(vehicle, "choose_design", body)
        dress = built_scene.with_chosen_textures

        def textures(mesh, seed):  # type: ignore[no-untyped-def]
            dressed = dress(mesh, seed)
            names = {each.texture for each in dressed.materials}
            # A family's name alone is its first variant.
            full = {texture_library().names[texture_library().index(name)] for name in names}
            self.names |= {f"texture/{name}" for name in full if not shared(name.partition("/")[0])}
            self.names.add(f"seed/{seed}")
            return dressed

        monkeypatch.setattr(built_scene, "with_chosen_textures", textures)
        built_scene._vehicle.cache_clear()

    def of(self, part: Assets, scenes: int) -> set[str]:
        """Names of what scenes are made of: streets, highways, and a drive."""
        self.names.clear()
        built_scene._vehicle.cache_clear()
        for number in range(scenes):
            kind = RoadType.HIGHWAY if number % 4 == 3 else RoadType.STREET
            posed = posed_scene_of_layout(generate_layout(number, kind), assets=part)
            posed.built.scene(posed.instant.actors, 0)
        posed = drive_scenes(3, 0, 2, egos=2, assets=part)[0]
        posed.built.scene(posed.instant.actors, 0, posed.instant.egos)
        return set(self.names)


@pytest.mark.slow
def test_scenes_of_the_two_parts_share_no_asset(monkeypatch: pytest.MonkeyPatch) -> None:
    used = Used(monkeypatch)
    train, judge, every = (used.of(part, 16) for part in (*PARTS, Assets.ALL))
    assert sorted(train & judge) == []
    assert {name for name in every if name.startswith("texture/brick")}
    for kind in ("building", "plant", "furniture", "place", "texture", "vehicle", "seed"):
        for part in (train, judge):
            assert any(name.startswith(kind + "/") for name in part), kind
    # All of them have some of both.
    assert every & train
    assert every & judge
