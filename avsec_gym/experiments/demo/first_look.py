"""What the demo is about, before anything is rendered: its first scene, driven blind and seeing."""

from __future__ import annotations

from markupsafe import Markup

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.episode_drawing import draw_episode_from_above
from avsec_gym.drawing.page_templates import page_templates
from avsec_gym.drawing.turnable_scene.page_part import turnable_part
from avsec_gym.drawing.turnable_scene.scene_data import DrivenBelief, turnable_scene
from avsec_gym.evaluation.contested import contested_layouts
from avsec_gym.experiments.procedural_frames import FIRST_SET
from avsec_gym.pipeline import run_episode
from avsec_gym.runs.section import Section
from avsec_gym.scenario.scene import Motion

_PACKAGE = "avsec_gym.experiments.demo"
TITLE = "What does a car do that sees nothing?"


def first_look(seed: int) -> Section:
    """The first contested scene of the demo with a seed, as two episodes.

    Args:
        seed: The demo's seed.
    """
    scenes = contested_layouts(1, seed=FIRST_SET + seed)
    (scene,) = scenes.labelled
    way = min(scenes.intentions[scene.id]) if scenes.intentions else None
    assert way is not None, "a contested scene is so with some intention"
    beliefs = {"a car that sees nothing": Boxes3D.empty(), "a car that sees all": scene.boxes}
    driven = [
        DrivenBelief(title, run_episode(scene, way, believed, motion=Motion.STATIC), believed)
        for title, believed in beliefs.items()
    ]
    turned = turnable_scene(f"The first scene, {way}", driven, scene.boxes)
    shown = (
        page_templates(_PACKAGE)
        .get_template("first_look.html.j2")
        .render(
            way=str(way),
            episodes=[
                (belief, Markup(draw_episode_from_above(belief.episode))) for belief in driven
            ],
            turned=turnable_part(turned),
        )
    )
    return Section(
        "first",
        "The first scene, driven twice",
        [
            "Each scene of the demo is one like this: it matters what the car sees.",
            "A car that drives by a detector sees something in between; under attack, less.  This"
            " page shows it as soon as a scene is attacked, and looks for that by itself.",
        ],
        [Markup(shown)],
    )
