"""Pictures of a run of chapter 5: attacks on a few scenes, repeated for their images."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from avsec_gym.errors import AvsecError
from avsec_gym.experiments.chapter5.attack_names import AttackName, attack_name
from avsec_gym.experiments.chapter5.outcomes import Outcomes
from avsec_gym.experiments.chapter5.patch_spreads import SpreadRow
from avsec_gym.experiments.chapter5.scenes import OPTIONS
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import ReportRequest

if TYPE_CHECKING:
    from avsec_gym.experiments.chapter5.section.scene_strip import SceneStrip
    from avsec_gym.experiments.chapter5.section.spread_pictures import SpreadPicture
    from avsec_gym.experiments.chapter5.section.telling_scenes import Telling

SPREAD = "feature_spread.png"
"""The file of figure 5.8."""


def strips_of(
    run: RunFolder,
    outcomes: Outcomes | None,
    request: ReportRequest,
    choose: Callable[[Outcomes, int, float], list[Telling]] | None = None,
    name: AttackName = attack_name,
) -> tuple[list[SceneStrip], list[str]]:
    """Strips of the most telling scenes, and the reason if there are none.

    A strip that this process has made of the run is not made again.

    Args:
        run: The run.
        outcomes: The run's outcomes, if it has any of chapter 5.
        request: The number of pictures that are asked for.
        choose: The function that picks the shown episodes, of the outcomes, at most how many, and
            the least score of a detection that is planned on; None: `telling_scenes`.
        name: The function that words attacks.
    """
    from avsec_gym.experiments.chapter5.section.telling_scenes import telling_scenes

    if outcomes is None:
        return [], []
    options = {**OPTIONS, **run.configuration.options}
    telling = (choose or telling_scenes)(outcomes, request.pictures, options["score_threshold"])
    if not telling:
        return [], []
    made = _strips_made(run.path.resolve(), run.manifest["started"])
    if missing := [shown for shown in telling if shown not in made]:
        from avsec_gym.experiments.chapter5 import attacked_episodes
        from avsec_gym.experiments.chapter5.section.scene_strip import scene_strips

        run.use_its_threads()
        try:
            episodes = attacked_episodes.AttackedEpisodes(run.configuration)
            with request.progress("repeating attacks") as on_progress:
                strips = scene_strips(missing, outcomes, episodes, on_progress, name)
        except AvsecError as error:
            return [], [f"no pictures: {error}"]
        made.update(zip(missing, strips, strict=True))
    return [made[shown] for shown in telling], []


@cache
def _strips_made(run: Path, started: str) -> dict[Telling, SceneStrip]:
    """What this process has made of a run, whose page is written more than once by a demo.

    Args:
        run: The run's folder.
        started: When the run began: another one may follow in the same folder.
    """
    return {}


def maps_of(
    run: RunFolder, rows: Sequence[SpreadRow], request: ReportRequest
) -> tuple[list[SpreadPicture], list[str]]:
    """Feature maps that patches change, and the reason if there are none.

    Args:
        run: The run.
        rows: The spread in each layer.
        request: Whether there are pictures, and whether they become files.
    """
    if not rows or not request.pictures:
        return [], []
    from avsec_gym.experiments.chapter5 import patch_spreads
    from avsec_gym.experiments.chapter5.feature_spread_figure import draw_feature_spread
    from avsec_gym.experiments.chapter5.section.spread_pictures import (
        shown_spreads,
        spread_picture,
    )

    run.use_its_threads()
    try:
        with request.progress("following patches") as shown:
            spreads = shown_spreads(rows, patch_spreads.PatchSpreads(run.configuration), shown)
    except AvsecError as error:
        return [], [f"no feature maps: {error}"]
    if request.keeps_pictures:
        draw_feature_spread(spreads, run.figures / SPREAD)
    return [spread_picture(title, each) for title, each in spreads.items()], []
