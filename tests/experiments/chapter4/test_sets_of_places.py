"""What constants, the model, thresholds and rates are of: no set of places serves two of them."""

from __future__ import annotations

import json

from avsec_gym.experiments.chapter4.procedural_instants import ASSETS, FIRST_SET
from avsec_gym.experiments.chapter4.settings import FITTED, JUDGED
from avsec_gym.validation.connected.fit import SHIPPED_FIT
from avsec_gym.validation.connected.learned.learned_fit import SHIPPED_MODEL
from avsec_gym.world.assets import Assets
from studies.catalogue import STUDIES

SEEDS = range(1000)
"""Seeds that a run of chapter 4 takes."""
LOOKED_AT = 2
"""The seed whose judged places were seen while rules were made."""


def test_fit_model_thresholds_and_judged_places_differ() -> None:
    fit = json.loads(SHIPPED_FIT.read_text())["data"]
    model = json.loads(SHIPPED_MODEL.read_text())["card"]["data"]
    sets = [
        {fit["seed"]},
        {model["seed"]},
        {FIRST_SET[FITTED] + seed for seed in SEEDS},
        {FIRST_SET[JUDGED] + seed for seed in SEEDS},
    ]
    assert len(set.union(*sets)) == sum(map(len, sets))
    assert fit["assets"] == model["assets"] == str(ASSETS[FITTED]) == str(Assets.TRAIN)
    assert ASSETS[JUDGED] == Assets.JUDGE


def test_the_study_judges_places_that_rules_were_not_made_on() -> None:
    words = STUDIES["chapter4"].steps[0].words
    assert int(words[words.index("--seed") + 1]) != LOOKED_AT
    assert "--retry" in words
