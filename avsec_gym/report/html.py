"""A run's report as one HTML page that needs nothing else: styles, script, pictures inside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from avsec_gym.drawing.page_table import Table, bounds, number
from avsec_gym.experiments.chapter3.defence.in_words import defence_sentences
from avsec_gym.experiments.chapter3.defence.plots import draw_defence, legend_of_defence
from avsec_gym.experiments.chapter3.defence.tables import tables_of_defence
from avsec_gym.experiments.chapter3.identification.in_words import (
    five_sentences,
    validation_sentences,
)
from avsec_gym.experiments.chapter3.identification.plots import figures_of_validation
from avsec_gym.experiments.chapter3.identification.tables import tables_of_validation
from avsec_gym.experiments.chapter3.identification.tables_of_five_sensors import tables_of_five
from avsec_gym.experiments.chapter3.localisation.in_words import localisation_sentences
from avsec_gym.experiments.chapter3.localisation.repair_pictures import RepairPicture
from avsec_gym.experiments.chapter3.localisation.tables import tables_of_localisation
from avsec_gym.experiments.chapter3.objects.in_words import optical_sentences
from avsec_gym.experiments.chapter3.objects.plots import CURVES, draw_sensitivity
from avsec_gym.experiments.chapter3.objects.tables import tables_of_optical_attacks
from avsec_gym.experiments.chapter5.section.plots_ghosts import PLACE_WORDS, draw_ghosts
from avsec_gym.experiments.chapter5.section.plots_losses import draw_losses, legend
from avsec_gym.experiments.chapter5.section.plots_steps import RATES, draw_precision, draw_safety
from avsec_gym.experiments.chapter5.section.scene_strip import Strip
from avsec_gym.experiments.chapter5.section.spread_pictures import SpreadPicture
from avsec_gym.experiments.chapter5.section.tables_beyond import (
    control_table,
    flip_table,
    loss_table,
    other_table,
    paired_table,
    patch_effect_table,
    rounding_table,
    seen_table,
    time_table,
    trend_table,
)
from avsec_gym.experiments.chapter5.section.tables_of_thesis import tables_of_thesis
from avsec_gym.experiments.chapter5.section.tables_why import (
    ghost_table,
    pyramid_table,
    spread_table,
)
from avsec_gym.experiments.chapter5.section.telling_scenes import RULES
from avsec_gym.report.run_remarks import facts, inputs, remarks

Report = Mapping[str, Any]
_SECTIONS = {
    "scenes": "Scenes",
    "losses": "What attacks take",
    "precision": "Precision",
    "safety": "Driving safety",
    "ghosts": "Ghosts",
    "spread": "Spread of a patch",
    "controls": "Controls",
    "flips": "Flips",
    "validation": "Sensor data validation",
    "five": "Two of five sensors attacked",
    "optical": "Detectors under optical attacks",
    "localisation": "Damage and its repair",
    "defence": "What a defence is worth",
    "other": "Other settings",
    "run": "The run",
}

_PARTS = ("answer", "decoupling", "scenarios", "trends", "rounding", "pyramid", "validation")
"""Of a report, that others than those of chapter 5 lack."""


def html_page(
    report: Report,
    strips: Sequence[Strip] = (),
    spreads: Sequence[SpreadPicture] = (),
    repairs: Sequence[RepairPicture] = (),
) -> str:
    """The page.

    Args:
        report: As `avsec_gym.report.run_report.run_report` makes it; parts may lack.
        strips: Pictures of the most telling scenes.
        spreads: Pictures of feature maps.
        repairs: Pictures of repaired moments.
    """
    environment = Environment(
        loader=PackageLoader("avsec_gym.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    tables = _tables(report)
    found: dict[str, Any] = {
        "report": {**dict.fromkeys(_PARTS), **report},
        "run": report["manifest"],
        "remarks": remarks(report),
        "tables": tables,
        "drawings": _drawings(report),
        "legend": legend(report["decoupling"]["attacks"]) if "decoupling" in report else (),
        "strips": strips,
        "spreads": spreads,
        "repairs": repairs,
        "places": PLACE_WORDS,
        "rules": RULES,
        "rho": _rho(report) if "decoupling" in report else "",
        "sentences": validation_sentences(report["validation"]) if report.get("validation") else [],
        "five_sentences": five_sentences(report),
        "optical_sentences": optical_sentences(report),
        "localisation_sentences": localisation_sentences(report),
        "defence_sentences": defence_sentences(report),
        "defence_marks": legend_of_defence(),
        "curves": CURVES,
        "facts": facts(report),
        "inputs": inputs(report),
        "bars": _bars(report),
        "sections": [(name, _SECTIONS[name]) for name in _shown(report, tables, strips)],
        "css": Markup(_source(environment, "report.css")),
        "js": Markup(_source(environment, "report.js")),
    }  # fmt: skip
    return environment.get_template("report.html.j2").render(found)


def _tables(report: Report) -> dict[str, Any]:
    tables: dict[str, Table | list[Table]] = {
        "of_thesis": tables_of_thesis(report),
        "other": other_table(report["other"]),
        "time": time_table(report),
        "spread": spread_table(report["spread"]),
        "five": tables_of_five(report),
        "optical": tables_of_optical_attacks(report),
        "localisation": tables_of_localisation(report),
        "defence": tables_of_defence(report),
    }
    if report.get("validation"):
        tables["validation"] = tables_of_validation(report["validation"])
    if "decoupling" in report:
        tables |= {
            "losses": loss_table(report["decoupling"]["attacks"]),
            "paired": paired_table(report["safety"]),
            "seen": seen_table(report["seen"]),
            "ghosts": ghost_table(report["ghosts"]),
            "patch_effects": patch_effect_table(report["patch_effects"]),
            "pyramid": pyramid_table(report["pyramid"]),
            "controls": control_table(report["controls"]),
            "trends": trend_table(report["trends"]),
            "rounding": rounding_table(report["rounding"]),
            "flips": flip_table(report["flips"]),
        }
    return tables


def _drawings(report: Report) -> dict[str, Any]:
    summary = report.get("validation")
    found: dict[str, Any] = {"validation": figures_of_validation(summary) if summary else []}
    sizes = report.get("sensitivity")
    defence = report.get("defence")
    found["defence"] = draw_defence(defence) if defence else []
    found["sensitivity"] = draw_sensitivity(sizes) if sizes else []
    return found | (_drawings_of_chapter_5(report) if "decoupling" in report else {})


def _drawings_of_chapter_5(report: Report) -> dict[str, Any]:
    safety = [(words, draw_safety(report["safety"], rate)) for rate, words in RATES.items()]
    return {
        "losses": draw_losses(report["decoupling"]["attacks"]),
        "precision": draw_precision(report["precision"]),
        "safety": [(words, panels) for words, panels in safety if panels],
        "ghosts": draw_ghosts(report["ghosts"]),
    }


def _shown(report: Report, tables: Mapping[str, Any], strips: Sequence[Strip]) -> list[str]:
    whole = "decoupling" in report
    there = {
        "scenes": bool(strips),
        "losses": whole,
        "precision": whole,
        "safety": whole or bool(tables["of_thesis"]),
        "ghosts": whole,
        "spread": bool(report["spread"] or report.get("pyramid")),
        "controls": whole,
        "flips": whole,
        "validation": bool(report.get("validation")),
        "five": bool(tables["five"]),
        "optical": bool(tables["optical"]),
        "localisation": bool(tables["localisation"]),
        "defence": bool(tables["defence"]),
        "other": bool(report["other"]),
        "run": True,
    }
    return [name for name in _SECTIONS if there[name]]


def _rho(report: Report) -> str:
    both = report["decoupling"]["rank_correlation"]["both"]
    if both["rho"] is None:
        return ""
    return (
        "Over the attacks of both detectors together, the rank correlation of the loss of precision"
        f" with the loss of safety is ρ = {number(both['rho'], digits=2)}"
        f" {bounds(both['interval'], digits=2)} ({both['attacks']} attacks; controls, rounded"
        " pixels and changed scenes left out)."
    )


def _bars(report: Report) -> list[tuple[str, int, str]]:
    """Of each part: its name, share of the longest in percent, and what it took."""
    parts = report["timings"]["parts"]
    longest = max((part["seconds"] for part in parts.values()), default=0.0)
    order = sorted(parts, key=lambda name: -parts[name]["seconds"])
    return [
        (
            name,
            round(100 * parts[name]["seconds"] / longest) if longest else 0,
            f"{number(parts[name]['seconds'] / 60)} min,"
            f" {number(parts[name]['seconds'] / parts[name]['cells'], digits=2)} s a cell",
        )
        for name in order
    ]


def _source(environment: Environment, name: str) -> str:
    assert environment.loader is not None
    return environment.loader.get_source(environment, name)[0]
