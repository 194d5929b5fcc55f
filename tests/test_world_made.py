"""docs/world_made.md states what is true of the code, and shows the pictures that a study makes."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from avsec_gym.world.labels import FULLY_VISIBLE, PARTLY_VISIBLE
from avsec_gym.world.models.buildings import KINDS
from avsec_gym.world.models.plants import SPECIES, VARIANTS
from avsec_gym.world.models.vehicles.designs import body_designs
from avsec_gym.world.rendering.ambient import RAYS
from avsec_gym.world.rendering.lidar import Lidar
from avsec_gym.world.rendering.light import draw_light
from avsec_gym.world.scenery.composition import MANNERS
from avsec_gym.world.site import Style
from studies.catalogue import STUDIES
from studies.world.gallery import PICTURES

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs/world_made.md").read_text()
LARGEST = 1.2e6
"""Bytes of all pictures of the page."""


def test_its_numbers_are_those_of_the_code() -> None:
    lidar = Lidar()
    words = " ".join(PAGE.split())
    for stated in (
        f"one of {MANNERS} manners",
        f"{len(SPECIES)} species of {VARIANTS} variants each",
        f"one of {len(body_designs())} body designs",
        f"{RAYS} rays into the half space",
        f"{len(lidar.lasers.elevation)} lasers fire {lidar.columns:,} times in a turn",
        f"a turn of {lidar.period:g} s",
        f"steps at {FULLY_VISIBLE:.2f} and {PARTLY_VISIBLE:.2f}",
    ):
        assert stated in words, stated
    assert len(KINDS) == 7
    assert "There are seven kinds" in words
    rng = np.random.default_rng(0)
    heights = np.degrees([draw_light(rng).elevation for _ in range(1000)])
    low, high = re.search(r"(\d+) to (\d+) degrees high", words).groups()  # type: ignore[union-attr]
    assert (round(heights.min()), round(heights.max())) == (int(low), int(high))
    styles = re.search(r"style of a street \((.+?)\)", words)[1]  # type: ignore[index]
    assert set(styles.split(", ")) == set(Style) - {Style.HIGHWAY}


def test_its_pictures_are_those_of_the_study() -> None:
    shown = re.findall(r"!\[.*?\]\((images/.*?)\)", PAGE)
    assert sorted(shown) == sorted(f"images/{name}.jpg" for name in PICTURES)
    assert sorted(STUDIES["world_gallery"].writes) == sorted(f"docs/{name}" for name in shown)
    assert sum((ROOT / "docs" / name).stat().st_size for name in shown) < LARGEST


def test_every_step_of_its_table_is_described() -> None:
    for anchor in re.findall(r"^\| \[.*?\]\(#(.*?)\)", PAGE, re.MULTILINE):
        assert re.search(rf"^### {anchor.replace('-', ' ')}$", PAGE, re.MULTILINE | re.IGNORECASE)
