"""The table of 300 scenes in closed loop: rates and scores of each setting in each set of scenes.

    python -m studies.driving_safety.closed_loop --runs runs/closed_loop_scenes --json FILE

reads what `avsec drive` left in the folders of `SETS` below that folder, of these those that are
there; studies/catalogue.toml has the commands.  ``labels``, ``drives`` and ``tracking`` are driven
with truth, blind, and every shipped error model.  ``rendered``, ``rendered_pgd`` and ``models``
render: all three drive contested scenes (`contested_drives`), since an error model has nothing to
validate, and drives in which nothing is in the way show little.  In ``models`` error models
drive them, too, and are held against what they are models of: a setting ``rendered_dsgn_patch``
beside them, or one of ``rendered`` and ``rendered_pgd``.  `closed_loop_page` shows the result.
Settings that are added, such as an error model of a detector under an attack, come into the table
by themselves.  Every collision at fault under truth is listed, with its certificates: whether no
car could have avoided it, and from when on no plan did.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.closed_loop.drive_film import read_film
from avsec_gym.closed_loop.loop_scenes import loop_scenes
from avsec_gym.closed_loop.no_way_out import no_way_out
from avsec_gym.closed_loop.unavoidable import unavoidable
from avsec_gym.drives.drive_folder import RECORD, ROWS, film_file
from avsec_gym.drives.drive_row import DriveRow
from avsec_gym.drives.summary import Cluster, SettingSummary, by_recording, by_scene, summaries
from avsec_gym.experiments.json_rows import FLAT, OPTIONAL, row_json
from avsec_gym.metrics.cluster_bootstrap import ClusterBootstrap, sampled_rank_correlation
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.text_files import read_text, write_text
from studies.driving_safety.contested_drives import read_contested
from studies.driving_safety.error_models.cases import DETECTORS

SETS = {
    "labels": by_scene,
    "drives": by_scene,
    "tracking": by_recording,
    "rendered": by_scene,
    "rendered_pgd": by_scene,
    "models": by_scene,
}
"""Folders, and which of their drives are one cluster."""
MODELLED = ("labels", "drives", "tracking")
"""Folders of the 300 scenes, which every error model drives."""
CONTESTED = "contested.json"
"""What `contested_drives` found, beside the folders."""
TRUTH, BLIND = "truth", "blind"
RENDERED = "rendered_"
"""What the name of a setting begins with that renders what an error model is a model of."""
COUNTERPARTS = {
    "stereo_rcnn": ("rendered", "detector"),
    "stereo_rcnn_patch": ("rendered", "attacked_patch"),
    "stereo_rcnn_thesis_pgd": ("rendered_pgd", "attacked_thesis_pgd"),
}
"""The set and the setting of other models: they are rendered once."""
FEWEST = 50
"""Scenes in which a model is held against rendered sensors, at least, before it is believed."""
_RESAMPLES = 2000


@dataclass(frozen=True)
class Ranking:
    """Whether settings that are dangerous in a single query are so when one drives on.

    Args:
        rho: Spearman's correlation, over settings, of the share of first plans that are not safe
            with the share of drives with a collision; None: one of them is the same for all, or
            there are fewer than three settings.
        interval: The 95 % interval over resampled clusters; None: there is none.
    """

    rho: float | None
    interval: tuple[float, float] | None


@dataclass(frozen=True)
class PooledRanking:
    """A ranking over the scenes of all `MODELLED` sets.

    Args:
        of: The detector whose settings are ranked, left alone and attacked; empty: all.
        first_plans: The settings, that with the fewest unsafe first plans first.
        loop: The settings, that with the fewest collisions first.
        ranking: The rank correlation of both.
    """

    of: str
    first_plans: Sequence[str]
    loop: Sequence[str]
    ranking: Ranking


@dataclass(frozen=True)
class LoopSettingRates:
    """A setting.

    Args:
        summary: Rates and means of its drives.
        first_plan: Share of first plans that are safe, were they driven to their ends.
    """

    summary: SettingSummary = field(metadata=FLAT)
    first_plan: Share


@dataclass(frozen=True)
class CollisionAtFault:
    """A collision at fault of a car that knew the truth.

    Args:
        scenario: Id of the scene.
        intention: The driving intention.
        unavoidable_after: Time by which any car, whatever it does from the start on, has touched
            something, s; None: there is no such certificate.
        no_plan_since: The replanning from which on a complete search of the driver's primitives
            found no plan without a collision, s after the start; None: from the last replanning
            before the collision there was one, or the search met its limit.
    """

    scenario: str
    intention: str
    unavoidable_after: float | None
    no_plan_since: float | None


@dataclass(frozen=True)
class LoopTable:
    """The drives in one set of scenes.

    Args:
        clusters: Number of clusters.
        settings: A row for each setting.
        ranking: Whether the ranking of the single query survives the loop.
        truth_at_fault: The collisions at fault under truth.
    """

    clusters: int
    settings: Sequence[LoopSettingRates]
    ranking: Ranking
    truth_at_fault: Sequence[CollisionAtFault]


@dataclass(frozen=True)
class JudgedModel:
    """An error model held against rendered sensors, on the same scenes.

    Args:
        model: The model's name.
        rendered: Share of the rendered drives with a collision.
        modelled: The same of those with the model.
        believed: Whether the model's share lies within the interval of the rendered one, on
            `FEWEST` scenes or more; else no drive by it is evidence about the detector.
    """

    model: str
    rendered: Share
    modelled: Share
    believed: bool


@dataclass(frozen=True)
class LoopTables:
    """A table for each of `SETS`; None: there are no drives."""

    labels: LoopTable | None = field(default=None, metadata=OPTIONAL)
    drives: LoopTable | None = field(default=None, metadata=OPTIONAL)
    tracking: LoopTable | None = field(default=None, metadata=OPTIONAL)
    rendered: LoopTable | None = field(default=None, metadata=OPTIONAL)
    rendered_pgd: LoopTable | None = field(default=None, metadata=OPTIONAL)
    models: LoopTable | None = field(default=None, metadata=OPTIONAL)
    pooled: Sequence[PooledRanking] = ()
    """Rankings over `MODELLED`."""
    looked_at: int | None = field(default=None, metadata=OPTIONAL)
    """Number of procedural drives among which the contested ones were found."""
    judged_models: Sequence[JudgedModel] = ()
    """The error models of ``models``."""


def table(folder: Path) -> LoopTable:
    """The results of the drives in a folder, by setting.

    Args:
        folder: A folder of `avsec drive`, named as one of `SETS`.
    """
    rows = _rows(folder)
    settings = list(dict.fromkeys(row["setting"] for row in rows))
    cluster = SETS[folder.name]
    summary = summaries(rows, settings, cluster)
    attacked = [name for name in settings if name not in (TRUTH, BLIND)]
    return LoopTable(
        clusters=len({cluster(row) for row in rows}),
        settings=[
            LoopSettingRates(each, _first_plan(rows, each.setting, cluster)) for each in summary
        ],
        ranking=ranking(rows, attacked, cluster),
        truth_at_fault=_explained(folder, rows),
    )


def pooled_rankings(rows: Mapping[str, Sequence[DriveRow]]) -> list[PooledRanking]:
    """The rankings over several sets: of all settings with errors, and of each detector's.

    Args:
        rows: Rows of drives by the name of their set, of `SETS`.
    """
    # A cluster of one set is none of another.
    every: list[Any] = [
        {**row, "scenario": f"{name} {SETS[name](row)}"}
        for name, own in rows.items()
        for row in own
    ]
    named = dict.fromkeys(row["setting"] for row in every)
    settings = [name for name in named if name not in (TRUTH, BLIND)]
    groups = {"": settings} | {
        detector: [name for name in settings if f"{name}_".startswith(f"{detector}_")]
        for detector in DETECTORS
    }
    return [
        PooledRanking(
            of,
            _ordered(every, group, lambda row: row["first_plan"] != "safe"),
            _ordered(every, group, lambda row: row["collision"]),
            ranking(every, group, by_scene),
        )
        for of, group in groups.items()
        if group
    ]


def _ordered(
    rows: Sequence[DriveRow], settings: Sequence[str], is_bad: Callable[[DriveRow], bool]
) -> list[str]:
    """The settings by the share of their drives that are bad, the least first."""
    shares = {
        name: np.mean([is_bad(row) for row in rows if row["setting"] == name]) for name in settings
    }
    return sorted(settings, key=lambda name: shares[name])


def judged_models(tables: Mapping[str, LoopTable]) -> list[JudgedModel]:
    """Every error model that has driven the scenes in which its detector was rendered.

    Args:
        tables: The drives by the name of their set; of ``models``, with settings ``MODEL`` and
            ``rendered_MODEL``.
    """
    judged = []
    for name, modelled in _collisions(tables, "models").items():
        where, setting = COUNTERPARTS.get(name, ("models", f"{RENDERED}{name}"))
        rendered = _collisions(tables, where).get(setting)
        if rendered is not None:
            believed = _is_within(modelled, rendered)
            judged.append(JudgedModel(name, rendered, modelled, believed))
    return judged


def _collisions(tables: Mapping[str, LoopTable], where: str) -> dict[str, Share]:
    """The share of drives with a collision of each setting in a set; empty without drives."""
    settings = tables[where].settings if where in tables else ()
    return {each.summary.setting: each.summary.rates["collision"] for each in settings}


def _is_within(modelled: Share, rendered: Share) -> bool:
    if modelled.rate is None or rendered.interval is None or rendered.of < FEWEST:
        return False
    low, high = rendered.interval
    return bool(low <= modelled.rate <= high)


def ranking(rows: Sequence[DriveRow], settings: Sequence[str], cluster: Cluster) -> Ranking:
    """The rank correlation between the single query and the closed loop.

    Args:
        rows: Rows of drives.
        settings: The settings that are ranked; all drive the same scenes.
        cluster: The drives that are resampled together.
    """
    clusters = {name: place for place, name in enumerate(dict.fromkeys(map(cluster, rows)))}
    counts = np.zeros((3, len(clusters), len(settings)))
    for row in rows:
        if row["setting"] in settings:
            place = clusters[cluster(row)], settings.index(row["setting"])
            counts[(slice(None), *place)] += (1, row["first_plan"] != "safe", row["collision"])
    drawn = ClusterBootstrap(len(clusters), _RESAMPLES)
    rho = sampled_rank_correlation(
        [
            (drawn.ratio(unsafe, drives), drawn.ratio(collisions, drives))
            for drives, unsafe, collisions in np.moveaxis(counts, 2, 0)
        ]
    )
    if rho is None:
        return Ranking(None, None)
    interval = rho.interval_around
    return Ranking(rho.value, None if interval is None else (interval[0], interval[1]))


def _rows(folder: Path) -> list[DriveRow]:
    return [json.loads(line) for line in read_text(folder / ROWS).splitlines() if line]


def _first_plan(rows: Sequence[DriveRow], setting: str, cluster: Cluster) -> Share:
    own = [row for row in rows if row["setting"] == setting]
    return share_of([row["first_plan"] == "safe" for row in own], [cluster(row) for row in own])


def _explained(folder: Path, rows: Sequence[DriveRow]) -> list[CollisionAtFault]:
    """The collisions at fault of a car that knew the truth."""
    blamed = [row for row in rows if row["setting"] == TRUTH and row["at_fault"]]
    if not blamed:
        return []
    record = read_json_object(folder / RECORD, remedy="Run `avsec drive` again.")
    scenes = loop_scenes(**record["scenarios"])
    found = []
    for row in blamed:
        scene, film = scenes.scene(row["scenario"]), read_film(film_file(folder, row["id"]))
        proof = unavoidable(scene)
        searched = no_way_out(scene, film.replannings(), float(film.times[-1]))
        found.append(
            CollisionAtFault(
                row["scenario"],
                row["intention"],
                unavoidable_after=None if proof is None else proof.time,
                no_plan_since=None if searched is None else searched.since,
            )
        )
    return found


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=Path, required=True)
    parser.add_argument("--json", type=Path, required=True)
    given = parser.parse_args()
    there = [name for name in SETS if (given.runs / name).is_dir()]
    tables = {name: table(given.runs / name) for name in there}
    modelled = {name: _rows(given.runs / name) for name in MODELLED if name in tables}
    contested = given.runs / CONTESTED
    result = LoopTables(
        **tables,
        pooled=pooled_rankings(modelled) if modelled else (),
        looked_at=read_contested(contested).looked_at if contested.is_file() else None,
        judged_models=judged_models(tables),
    )
    write_text(given.json, json.dumps(row_json(result), indent=1) + "\n", overwrite=True)


if __name__ == "__main__":
    main()
