"""Show what `studies.attackers.quiet_laser --json` found: a figure and a page.

python -m studies.attackers.quiet_laser_page quiet_laser.json --figure laser.png --markdown laser.md
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from avsec_gym.drawing.figure_style import FAINT, FIGURE_STYLE
from avsec_gym.drawing.scenario_picture import save_picture
from avsec_gym.report.markdown_table import interval, markdown_table, number
from avsec_gym.storage.text_files import read_text, write_text
from studies.attackers.laser_attempts import BY_HAND, LEARNERS
from studies.attackers.quiet_laser import RATES, ROWS

COLOURS = {"quiet": "#1F77B4", "loud": "#D7263D"}
MARKERS = {"sac": ("o", "SAC"), "cma_es": ("s", "CMA-ES"), "random_search": ("^", "random search")}


def draw(attackers: Mapping[str, Mapping[str, Any]]) -> Figure:
    """Every attacker by how often it raises an alarm and how often it makes the drive unsafe."""
    style: dict[Any, Any] = {**FIGURE_STYLE}
    with mpl.rc_context(style):
        figure = Figure(figsize=(6.6, 4.6), dpi=120, facecolor="white", layout="constrained")
        axes = figure.subplots()
        by_hand = [attackers[name] for name in BY_HAND]
        places = [(100 * row["alarm"]["rate"], 100 * row["unsafe"]["rate"]) for row in by_hand]
        axes.plot(*zip(*places, strict=True), color=FAINT, lw=1, zorder=1)
        for row, place in zip(by_hand, places, strict=True):
            point(axes, row, FAINT, "D", "by hand, full light" if row is by_hand[0] else "")
            label = f"{row['radius']:.0f} px"
            beside = (6, -12) if place[0] < 90 else (-36, -14)
            axes.annotate(label, place, beside, textcoords="offset points", color=FAINT)
        for who in LEARNERS:
            for how, colour in COLOURS.items():
                marker, title = MARKERS[who]
                point(axes, attackers[f"{how}_{who}"], colour, marker, f"{how}, {title}")
        point(axes, attackers["random_shot"], "black", "x", "random shot")
        point(axes, attackers["thesis_facula"], "black", "+", "the thesis' facula")
        axes.set(xlim=(-4, 104), ylim=(-4, 104))
        axes.set(xlabel="with an alarm, % of drives", ylabel="unsafe, % of drives")
        axes.legend(frameon=False, loc="lower right", fontsize=8)
    return figure


def point(axes: Any, row: Mapping[str, Any], colour: str, marker: str, label: str) -> None:
    """A point with both intervals."""
    x, y = (100 * row[name]["rate"] for name in ("alarm", "unsafe"))
    spread = [
        [[100 * abs(row[name]["rate"] - bound)] for bound in row[name]["interval"]]
        for name in ("alarm", "unsafe")
    ]
    how = {"color": colour, "marker": marker, "ls": "", "lw": 0.6, "label": label}
    axes.errorbar(x, y, xerr=spread[0], yerr=spread[1], **how)


def page(result: Mapping[str, Any], figure: str) -> list[str]:
    """Lines of Markdown."""
    rows = [
        [
            titled(name),
            *(rated(result["attackers"][name][rate]) for rate in RATES),
            *(number(result["attackers"][name][figure], 0) for figure in ("radius", "strength")),
        ]
        for name in ROWS
    ]
    costs = [
        [titled(who), *(rated(differences[rate], "difference") for rate in RATES)]
        for who, differences in result["quiet_less_loud"].items()
    ]
    titles = [f"{rate.replace('_', ' ')}, %" for rate in RATES]
    return [
        "# What quietness costs a laser",
        "",
        f"One attempt at what is in the way, in {len(result['situations'])} situations that are"
        f" driven safely without an attack; detector `{result['detector']}`; thresholds of"
        f" {result['scenes']['thresholds']} clean scenes at r ="
        f" {100 * result['false_alarm_rate']:g} %. A training has"
        f" {result['training_attempts']} attempts in other scenes; of each there are"
        f" {len(result['seeds'])}. *Quiet*: paid for unsafe"
        " drives without an alarm; *loud*: for all unsafe drives. In brackets 95 % intervals"
        " (`studies/attackers/quiet_laser.py` shows how).",
        "",
        "```",
        "python -m studies.attackers.quiet_laser --json > studies/results/quiet_laser.json",
        "```",
        "",
        f"![Unsafe drives against alarms, by attacker]({figure})",
        "",
        *markdown_table(["attacker", *titles, "radius, px", "strength"], rows),
        "",
        "Quiet less loud, in points:",
        "",
        *markdown_table(["learner", *titles], costs),
        "",
        "Numbers, each situation's outcome and each training's rate:"
        " [quiet_laser.json](quiet_laser.json).",
    ]


def titled(name: str) -> str:
    """As people write it."""
    text = name.replace("cma_es", "CMA-ES").replace("sac", "SAC").replace("thesis", "the thesis'")
    radius = text.removeprefix("by_hand_")
    return f"by hand, {radius} px" if radius != text else text.replace("_", " ")


def rated(found: Mapping[str, Any], name: str = "rate") -> str:
    """A rate in percent, with its interval."""
    return interval(100 * found[name], [100 * bound for bound in found["interval"]])


def main() -> None:
    """Read, draw, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("result", type=Path, help="JSON of the study")
    parser.add_argument(
        "--figure", type=Path, default=Path("studies/results/images/quiet_laser.png")
    )
    parser.add_argument("--markdown", type=Path, default=Path("studies/results/quiet_laser.md"))
    options = parser.parse_args()
    result = json.loads(read_text(options.result))
    save_picture(draw(result["attackers"]), options.figure, overwrite=True)
    shown = Path(os.path.relpath(options.figure, options.markdown.parent)).as_posix()
    write_text(options.markdown, "\n".join(page(result, shown)) + "\n", overwrite=True)


if __name__ == "__main__":
    main()
