"""Garden walls and fences, along x from -length / 2 to length / 2, to be seen from both sides."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.buildings import palette
from avsec_gym.world.models.buildings.facade import BELOW_GROUND
from avsec_gym.world.models.buildings.panels import Panels, boxes, solid


def garden_wall(length: float, rng: np.random.Generator) -> Mesh:
    """A low wall of stone or stucco with a coping, often with a railing between pillars.

    Its middle line is the x axis, it is at most 0.5 m thick and reaches 0.6 m below the ground.

    Args:
        length: Length of the wall, metres.
        rng: Generator that draws the kind.
    """
    high, half = float(rng.uniform(0.45, 0.9)), 0.5 * length
    stone = palette.pick(
        rng,
        Material("rubble"),
        Material("rubble", (0.8, 0.76, 0.7)),
        palette.stucco(rng),
        palette.sandstone(rng),
        Material("concrete/2"),
    )
    coping = palette.darker(palette.CONCRETE, 0.7)
    parts = [
        boxes(stone, (-half, -0.12, BELOW_GROUND), (half, 0.12, high), without=("bottom", "top")),
        boxes(coping, (-half, -0.16, high), (half, 0.16, high + 0.06)),
    ]
    if rng.random() < 0.7:
        parts += _railing(length, high + 0.06, rng)
        pillars = np.linspace(-half + 0.22, half - 0.22, max(2, round(length / 4.0) + 1))
        low = np.stack([pillars - 0.2, *np.full((2, len(pillars)), [[-0.2], [0.0]])], axis=1)
        top = np.add(low, (0.4, 0.4, high + 0.75))
        low[:, 2] = BELOW_GROUND
        parts += [
            boxes(stone, low, top, without=("top", "bottom")),
            boxes(coping, np.subtract(top, (0.43, 0.43, 0.0)), np.add(top, (0.03, 0.03, 0.07))),
        ]
    return solid(parts)


def picket_fence(length: float, rng: np.random.Generator) -> Mesh:
    """Wooden boards on two rails; the boards look at the street (-y).

    Args:
        length: Length of the fence, metres.
        rng: Generator that draws height, spacing and colour.
    """
    wood = palette.pick(
        rng,
        Material("timber/0"),
        Material("timber/1"),
        Material("timber/0", (0.6, 0.6, 0.6)),
        palette.WHITE,
    )
    high, pitch = float(rng.uniform(0.8, 1.15)), float(rng.uniform(0.125, 0.17))
    half = 0.5 * length
    x = np.arange(-half, half - 0.08, pitch)
    low = np.stack([x, *np.full((2, len(x)), [[-0.05], [0.05]])], axis=1)
    boards = boxes(wood, low, np.add(low, (0.08, 0.025, high - 0.05)), without=("bottom",))
    rails = boxes(
        wood,
        [(-half, -0.025, 0.25 * high), (-half, -0.025, 0.75 * high)],
        [(half, 0.02, 0.25 * high + 0.07), (half, 0.02, 0.75 * high + 0.07)],
    )
    at = np.linspace(-half + 0.05, half - 0.05, max(2, round(length / 2.5) + 1))
    foot = np.stack([at - 0.05, *np.full((2, len(at)), [[0.02], [BELOW_GROUND]])], axis=1)
    posts = boxes(
        wood, foot, np.add(foot, (0.1, 0.09, high - BELOW_GROUND - 0.03)), without=("bottom",)
    )
    return solid([boards, rails, posts])


def _railing(length: float, low: float, rng: np.random.Generator) -> list[Panels]:
    """Upright bars between two rails, of painted or rusty iron."""
    iron = palette.pick(
        rng,
        palette.IRON,
        Material("plain", (0.16, 0.2, 0.17), infrared=0.3),
        Material("plain", (0.2, 0.08, 0.04), infrared=0.3),
    )
    half, high, pitch = 0.5 * length, low + float(rng.uniform(0.4, 0.6)), 0.12
    x = np.arange(-half + 0.05, half - 0.05, pitch)
    start = np.stack([x, *np.full((2, len(x)), [[-0.015], [low + 0.05]])], axis=1)
    bars = boxes(iron, start, np.add(start, (0.03, 0.03, high - low)), without=("bottom",))
    rails = boxes(
        iron,
        [(-half, -0.03, low + 0.04), (-half, -0.03, high - 0.08)],
        [(half, 0.03, low + 0.08), (half, 0.03, high - 0.04)],
    )
    return [bars, rails]
