"""Where ghosts stand, from above: a map for each detector and attack."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_plots import Frame, Scale, band, drawing, text
from avsec_gym.drawing.page_table import number
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.ghost_positions import CORRIDOR, FARTHEST, GhostPlace
from avsec_gym.experiments.chapter5.ghost_shares import GhostRow
from avsec_gym.experiments.chapter5.settings import PERTURBATIONS, TEXTURE_ATTACKED, UNATTACKED

PLACE_WORDS = {
    GhostPlace.ROAD: "on the road",
    GhostPlace.SIDE: "beside it",
    GhostPlace.UNKNOWN: "neither",
}
_DRAWN = (UNATTACKED, PERTURBATIONS[-1], TEXTURE_ATTACKED)
_ASIDE = 20.0
_WIDTH, _HEIGHT = 330, 330
_FRAME = Frame(Scale(-_ASIDE, _ASIDE, 34, 324), Scale(0, FARTHEST, 296, 26))


def draw_ghosts(rows: Sequence[GhostRow]) -> list[str]:
    """A map of each detector unattacked, under the strongest perturbation, and with it retextured.

    Args:
        rows: Rows for all conditions.
    """
    return [_draw(row) for row in rows if row.condition.attack in _DRAWN]


def _draw(row: GhostRow) -> str:
    condition, ghosts = row.condition, row.summary.ghosts
    attack = attack_name(condition.attack, condition.strength)
    words = f"{detector_name(condition.detector)}, {attack}"
    sides = [[_FRAME.at((x, z)) for z in (0, FARTHEST)] for x in (-CORRIDOR, CORRIDOR)]
    parts = [
        band(sides[0], sides[1], "lanes"),
        _FRAME.axes(_FRAME.x.ticks(4), _FRAME.y.ticks(4)),
        text((_FRAME.x.start, 14), words, "name"),
        text(((_FRAME.x.start + _FRAME.x.end) / 2, _HEIGHT - 4), "metres to the right", "middle"),
    ]
    drawn = 0
    for place in reversed(GhostPlace):
        within = [_FRAME.at((x, z)) for x, z in row.positions[place] if abs(x) < _ASIDE]
        spots = "".join(f"M{x:g} {y:g}h0" for x, y in within)
        drawn += len(within)
        parts.append(f'<path d="{spots}" class="dots {place}"/>' if spots else "")
    count = f"{number(ghosts, digits=0)} ghost{'s' * (ghosts != 1)}"
    parts.append(text((_FRAME.x.end - 4, _FRAME.y.end + 14), count, "end"))
    label = f"{words}: {drawn} ghosts from above, by where they stand"
    return drawing(_WIDTH, _HEIGHT, parts, label)
