"""The demo's page: what was seen and done, episode by episode; rates and precision further down."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import Table, TableCell, figure, name
from avsec_gym.experiments.chapter5.attack_names import detector_name
from avsec_gym.experiments.chapter5.scenes import OPTIONS, scenes_of
from avsec_gym.experiments.chapter5.section.findings import outcomes_of
from avsec_gym.experiments.chapter5.section.pictures import strips_of
from avsec_gym.experiments.chapter5.section.sections import shown_strips, style_and_script
from avsec_gym.experiments.chapter5.settings import ATTACKS, UNATTACKED
from avsec_gym.experiments.demo.drive_on import FOLDER
from avsec_gym.experiments.demo.drive_section import driven_rows, driven_section
from avsec_gym.experiments.demo.experiment import FULL_REPORT, PATCH
from avsec_gym.experiments.demo.patch_in_words import demo_attack_name, grey_in_words
from avsec_gym.experiments.demo.rates import DemoRow, demo_rows
from avsec_gym.experiments.demo.story import (
    StoryRow,
    contested_ways,
    hits,
    sentences,
    story_rows,
)
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The story, its pictures first, then all rates.

    Raises:
        DataError: The labels of the run's scenes are not where they were.
    """
    outcomes = outcomes_of(run)
    if not outcomes.strongest:
        return Findings(remarks=["Nothing is done yet."])
    threshold = {**OPTIONS, **run.configuration.options}["score_threshold"]
    ways = contested_ways(scenes_of(run.configuration))
    story, rates = story_rows(outcomes, ways, threshold), demo_rows(outcomes)
    strips, problems = strips_of(
        run,
        outcomes,
        request,
        lambda found, count, least: hits(found, ways, count, least),
        demo_attack_name,
    )
    seen, all_episodes = _story_table(story), rate_table(rates, len(outcomes.scenarios))
    grey = grey_in_words(run, [row.detector for row in story if row.attack == PATCH])
    driven = driven_section(run.path / FOLDER)
    sections = [
        *([driven] if driven else []),
        Section(
            "story",
            "What the car saw, and what it did",
            [*sentences(story), *([grey] if grey else [])],
            [*([shown_strips(strips)] if strips else []), seen],
            link="The story",
            context=_CONTEXT if strips else "",
            text_tables=[seen],
        ),
        Section("rates", "All episodes, and precision", parts=[all_episodes], link="Rates"),
    ]
    style, script = style_and_script()
    return Findings(
        sections,
        {
            "story": as_json(story),
            "rates": as_json(rates),
            "drives": driven_rows(run.path / FOLDER),
        },
        {setting for setting, _ in run.settings()},
        {attack: demo_attack_name(attack) for attack in ATTACKS},
        extent=f"{len(outcomes.scenarios)} scenes",
        remarks=[_IN_PART] if run.missing() or run.failures() else [],
        problems=problems,
        style=style,
        script=script,
    )


_IN_PART = "All figures are of the scenes that every attack was done for."
_CONTEXT = (
    "Shown is, for each detector and attack, the first of these episodes that becomes unsafe; after"
    " them, others, chosen as in reports of chapter 5. Above: what the camera saw, with the boxes"
    " that the car believed in; below: what it did."
)


def _story_table(rows: Sequence[StoryRow]) -> Table:
    unattacked = {row.detector: row.safe for row in rows if row.attack == UNATTACKED}
    lines = [
        [
            name(detector_name(row.detector)),
            name(row.name),
            TableCell(f"{row.found} of {row.cars}", key=float(row.found)),
            TableCell(
                f"{row.safe} of {row.episodes}",
                key=float(row.safe),
                tone="bad" if row.safe < unattacked.get(row.detector, 0) else "",
            ),
        ]
        for row in rows
    ]
    return Table(
        "Cars found, and episodes that stayed safe",
        ["detector", "attack", "cars found", "safe episodes"],
        lines,
        "Found: a box that is planned on overlaps the car by more than half, from above. Episodes:"
        " those in which a car that sees nothing drives unsafely and one that sees all safely.",
        names=2,
    )


def rate_table(rows: Sequence[DemoRow], scenes: int) -> Table:
    """Rates and precision under each attack.

    Args:
        rows: The rows that `demo_rows` makes.
        scenes: The number of scenes that they are of.
    """
    lines = []
    for row in rows:
        rates = row.rates.to_json()
        is_truth = row.detector is None
        lines.append(
            [
                name("ground truth" if row.detector is None else detector_name(row.detector)),
                name("–" if is_truth else demo_attack_name(row.attack, row.strength)),
                *(
                    figure(rates[key], rates[f"{key}_interval"], scale=100)
                    for key in ("success_rate", "collision_rate", "safe_driving_rate")
                ),
                figure(row.precision, row.precision_interval),
                figure(row.precision_iou_low, row.precision_iou_low_interval),
            ]
        )
    episodes = rows[0].rates.scenarios
    counted = [row for row in rows if row.labels]
    ceiling = ""
    if counted:
        ceiling = (
            f" Precision is of {counted[0].labels} moderate cars, of which perfect detections reach"
            f" {counted[0].precision_ceiling:.1f}."
        )
    few = ""
    if scenes < FULL_REPORT:
        few = (
            f" {scenes} scenes show what attacks do, not how often, which “avsec run chapter5”"
            " measures; they are too few for intervals of precision."
        )
    bootstrap = "; of AP by bootstrap over scenes" if not few else ""
    return Table(
        f"{episodes} episodes left, straight and right",
        ["detector", "attack", "success, %", "collision, %", "safe driving, %", "AP at 0.7",
         "AP at 0.5"],
        lines,
        "In brackets: 95 % intervals, Wilson’s, widened by what the episodes of one scene share"
        f"{bootstrap}. AP: KITTI’s average precision of cars in 3D, moderate,"
        f" 11 recall points, by the overlap that is asked for.{ceiling}{few}",
        names=2,
    )  # fmt: skip
