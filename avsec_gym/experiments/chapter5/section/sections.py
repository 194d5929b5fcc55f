"""The sections of chapter 5, made of the figures that `findings` reads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib.resources import files
from typing import TYPE_CHECKING

from markupsafe import Markup

from avsec_gym.drawing.page_figure import (
    CaptionedImage,
    Figure,
    Key,
    PictureRow,
    line_key,
    mark_key,
)
from avsec_gym.drawing.page_table import Table, bounds, number
from avsec_gym.drawing.page_templates import page_templates
from avsec_gym.drawing.turnable_scene.page_part import (
    style_and_script as turnable_style_and_script,
)
from avsec_gym.experiments.chapter5.decoupling import Decoupling, RankCorrelation
from avsec_gym.experiments.chapter5.families import FamilyFigures
from avsec_gym.experiments.chapter5.figures import AttackFigures, ChapterFigures
from avsec_gym.experiments.chapter5.patch_spreads import SpreadRow
from avsec_gym.experiments.chapter5.pyramid import PyramidRow
from avsec_gym.experiments.chapter5.section.answer_in_words import WordedAnswer
from avsec_gym.experiments.chapter5.section.plots_ghosts import PLACE_WORDS, draw_ghosts
from avsec_gym.experiments.chapter5.section.plots_losses import draw_losses, legend
from avsec_gym.experiments.chapter5.section.plots_steps import RATES, draw_precision, draw_safety
from avsec_gym.experiments.chapter5.section.stronger_section import stronger_section
from avsec_gym.experiments.chapter5.section.tables_beyond import (
    control_table,
    flip_table,
    loss_table,
    paired_table,
    patch_effect_table,
    rounding_table,
    seen_table,
    trend_table,
)
from avsec_gym.experiments.chapter5.section.tables_families import (
    compared_table,
    contested_family_table,
    contested_loss_table,
    contested_rate_table,
    family_table,
)
from avsec_gym.experiments.chapter5.section.tables_of_thesis import tables_of_thesis
from avsec_gym.experiments.chapter5.section.tables_why import (
    ghost_table,
    pyramid_table,
    spread_table,
)
from avsec_gym.experiments.chapter5.section.telling_scenes import RULES
from avsec_gym.experiments.chapter5.tables import SafetyRow
from avsec_gym.runs.section import Answer, AnswerOn, Section, SectionPart

if TYPE_CHECKING:
    from avsec_gym.experiments.chapter5.section.scene_strip import SceneStrip
    from avsec_gym.experiments.chapter5.section.spread_pictures import SpreadPicture

_PACKAGE = "avsec_gym.experiments.chapter5.section"
_LINES = ("line-0", "line-1", "line-2")


def answer_of(worded: WordedAnswer, decoupling: Decoupling) -> Answer:
    """The answer to the chapter's question, with the picture of it."""
    attacks = decoupling.attacks
    figure = Figure(
        "What each attack takes",
        draw_losses(attacks),
        [*legend(attacks), mark_key("hollow theirs of-soft", "hollow: the thesis")],
        "Were precision a guide to safety, marks would climb to the right. A pair of attacks goes"
        " against that if one surely takes more precision and surely less safety, after Holm’s"
        " correction for all pairs of the detector. Thin crosses: 95 % bootstrap intervals over"
        " scenarios. Average precision of cars in 3D (IoU 0.7,"
        " moderate, 11 recall points), of a specific patch the mean over the intentions; safe"
        " driving over left, straight and right.",
    )
    cases = [
        AnswerOn(each.name, each.evidence, [*each.took, *each.families])
        for each in worded.detectors
    ]
    both = decoupling.rank_correlation["both"]
    together = ""
    if both.rho is not None:
        rho, interval = number(both.rho, digits=2), bounds(both.interval, digits=2)
        together = f"Both together: ρ = {rho} {interval} over {both.attacks} attacks."
    return Answer(worded.word, worded.sentence, cases, figure, together)


def scenes_section(strips: Sequence[SceneStrip]) -> Section:
    """Pictures of the most telling scenes.

    Args:
        strips: One for each scene.
    """
    parts = [shown_strips(strips)]
    return Section("scenes", "Seen in scenes", parts=parts, link="Scenes", context=RULES)


def shown_strips(strips: Sequence[SceneStrip]) -> Markup:
    """The pictures as HTML, for `style_and_script`."""
    return Markup(page_templates(_PACKAGE).get_template("scenes.html.j2").render(strips=strips))


def style_and_script() -> tuple[str, str]:
    """CSS and JavaScript of all these sections."""
    templates = files(_PACKAGE) / "templates"
    own = ((templates / name).read_text("utf-8") for name in ("chapter5.css", "chapter5.js"))
    style, script = ("\n".join(both) for both in zip(own, turnable_style_and_script(), strict=True))
    return style, script


def sections_of(figures: ChapterFigures) -> list[Section]:
    """What attacks take, and why; of a run of planners alone, their table."""
    of_thesis, found = tables_of_thesis(figures), figures.of_attacks
    if found is None:
        return [_safety_section((), of_thesis)] if of_thesis else []
    attacks, seen = found.decoupling.attacks, seen_table(found.seen)
    exact = [row for row in attacks if not row.condition.whole_levels]
    checks = [
        *([control_table(found.controls)] if found.controls else []),
        *([trend_table(found.trends)] if found.trends else []),
        *([rounding_table(found.rounding)] if found.rounding else []),
    ]
    return [
        Section(
            "losses",
            "What attacks take",
            parts=[loss_table(attacks), paired_table(found.safety), seen],
            context=_correlation(found.decoupling.rank_correlation["both"]),
            text_tables=[loss_table(exact), seen],
        ),
        *([_family_section(found.families)] if found.families.rows else []),
        *_contested_section(found),
        _precision_section(found, [table for table in of_thesis if _is_of_precision(table)]),
        _safety_section(
            found.safety, [table for table in of_thesis if not _is_of_precision(table)]
        ),
        *([stronger_section(found.stronger)] if found.stronger else []),
        _ghost_section(found),
        Section(
            "controls",
            "Are the attacks sane?",
            parts=checks,
            link="Controls",
        ),
        Section(
            "flips",
            "Which episodes became unsafe",
            parts=[flip_table(found.flips)],
            link="Flips",
            text_tables=(),
        ),
    ]


def spread_section(
    rows: Sequence[SpreadRow], pyramid: Sequence[PyramidRow], maps: Sequence[SpreadPicture] = ()
) -> list[Section]:
    """How far patches spread, in feature maps and without DSGN's pyramid; none without figures.

    Args:
        rows: The spread in each layer.
        pyramid: DSGN with its pyramid and without.
        maps: Pictures of feature maps.
    """
    parts: list[SectionPart] = [
        *([_map_figure(maps)] if maps else []),
        *([pyramid_table(pyramid)] if pyramid else []),
        *([spread_table(rows)] if rows else []),
    ]
    if not rows and not pyramid:
        return []
    return [Section("spread", "How far a patch spreads", parts=parts, link="Spread of a patch")]


def _family_section(families: FamilyFigures) -> Section:
    return Section(
        "families",
        "Within families of attacks",
        parts=[
            family_table(families),
            *([compared_table(families.compared)] if families.compared else []),
        ],
        link="Families",
        context="Perturbations take cars, patches add ghosts: whether precision tells of safety is"
        " asked within each, and what a point of precision costs in each.",
    )


def _contested_section(found: AttackFigures) -> list[Section]:
    """None where no scene of the run is contested."""
    contested = found.contested
    if contested is None:
        return []
    tables = [
        contested_rate_table(contested),
        contested_loss_table(found.decoupling.attacks, contested.decoupling.attacks),
        *(
            [contested_family_table(found.families, contested.families)]
            if found.families.rows
            else []
        ),
    ]
    return [
        Section(
            "contested",
            "Where it matters what a car sees",
            parts=tables,
            link="Contested scenes",
            context="In most scenes a car that sees nothing drives as safely as one that sees all."
            f" In {contested.episodes:,} episodes of {contested.scenarios:,} scenes it does not.",
        )
    ]


def _precision_section(found: AttackFigures, tables: Sequence[Table]) -> Section:
    drawings = draw_precision(found.precision)
    figure = Figure(
        "Figure 5.3: average precision over the steps n of the thesis' PGD, %",
        drawings,
        [
            *map(line_key, _LINES, ("easy", "moderate", "hard")),
            mark_key("hollow theirs of-soft", "the thesis, where it gives a number"),
        ],
        label="Figure 5.3",
    )
    return Section("precision", "Precision", parts=[*([figure] if drawings else []), *tables])


def _safety_section(rows: Sequence[SafetyRow], tables: Sequence[Table]) -> Section:
    return Section("safety", "Driving safety", parts=[*_safety_figures(rows), *tables])


def _safety_figures(rows: Sequence[SafetyRow]) -> Iterator[Figure]:
    keys = [*map(line_key, _LINES, ("left", "straight", "right"))]
    keys.append(line_key("dashed of-soft", "the thesis"))
    for rate, words in RATES.items():
        if drawings := draw_safety(rows, rate):
            title = f"Figure 5.4: {words} over the steps n of the thesis' PGD, %"
            yield Figure(title, drawings, keys, label=f"Figure 5.4, {words}")


def _ghost_section(found: AttackFigures) -> Section:
    drawings, effects = draw_ghosts(found.ghosts), found.patch_effects
    keys = [mark_key(place, words, size=4) for place, words in PLACE_WORDS.items()]
    lanes = "the three lanes that the car may take"
    figure = Figure(
        "Ghosts from above",
        drawings,
        [*keys, Key("lanes", '<span class="key"></span>', lanes)],
        "The camera stands below, in the middle; metres. At most the first 1,000 ghosts of each"
        " map, those that are farther aside left out.",
        layout="maps",
    )
    parts: list[SectionPart] = [
        *([figure] if drawings else []),
        ghost_table(found.ghosts),
        *([patch_effect_table(effects)] if effects else []),
    ]
    return Section("ghosts", "Where ghosts are", parts=parts, link="Ghosts")


def _map_figure(maps: Sequence[SpreadPicture]) -> Figure:
    rows = []
    for spread in maps:
        layers = [
            CaptionedImage(
                layer.image,
                layer.layer,
                layer.layer,
                small=f"{layer.radius:.1f} / {layer.radius_absolute:.1f}",
            )
            for layer in spread.maps
        ]
        seen = CaptionedImage(spread.image, "input", "The patch in the middle of the image")
        rows.append(PictureRow([seen, *layers], "layers", spread.title))
    return Figure(
        "Figure 5.8: what a patch changes in feature maps, from shallow to deep",
        pictures=rows,
        note="Central squares of 240 pixels, each map from no change (black) to its own largest."
        " Below: the radius that counts as changed in multiples of the patch’s, by the map’s"
        " maximum and by what another image would change.",
        label="Figure 5.8",
    )


def _correlation(both: RankCorrelation) -> str:
    if both.rho is None:
        return ""
    return (
        "Over the attacks of both detectors together, the rank correlation of the loss of precision"
        f" with the loss of safety is ρ = {number(both.rho, digits=2)}"
        f" {bounds(both.interval, digits=2)} ({both.attacks} attacks; controls, rounded"
        " pixels and changed scenes left out)."
    )


def _is_of_precision(table: Table) -> bool:
    return "precision" in table.title
