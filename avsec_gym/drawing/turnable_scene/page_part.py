"""A turnable scene as a part of a page: markup, and the style and the script of all of them."""

from __future__ import annotations

import json
from importlib.resources import files

from markupsafe import Markup

from avsec_gym.drawing.page_templates import page_templates
from avsec_gym.drawing.turnable_scene.scene_data import TurnableScene

_PACKAGE = "avsec_gym.drawing.turnable_scene"
_TEMPLATE = "turnable_scene.html.j2"


def turnable_part(scene: TurnableScene) -> Markup:
    """The scene behind a line that opens it; `style_and_script` makes it move.

    Args:
        scene: The scene.
    """
    # Nothing in it ends the element that holds it.
    data = json.dumps(scene.to_json(), separators=(",", ":")).replace("<", "\\u003c")
    return Markup(
        page_templates(_PACKAGE, "").get_template(_TEMPLATE).render(scene=scene, data=Markup(data))
    )


def style_and_script() -> tuple[str, str]:
    """CSS and JavaScript, once for all scenes of a page."""
    folder = files(_PACKAGE)
    style, script = (
        (folder / name).read_text("utf-8") for name in ("turnable_scene.css", "turnable_scene.js")
    )
    return style, script
