"""A module that neither commands nor environments reach belongs to studies/, or is library API.

The product is what `avsec` and `gym.make` run, with what these name by a string.  What only
studies use stands in studies/, what only tests use beside these.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.which import modules, steps_from

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "avsec_gym"

# Why it is in the package all the same, module, and the page or example that shows it to users.
LIBRARY = {
    # Proves that no plan led past a collision; a user asks it of a drive.
    "closed_loop.no_way_out": "docs/closed_loop.md",
    # Proves that no car could have avoided a collision; a user asks it of a scene.
    "closed_loop.unavoidable": "docs/closed_loop.md",
    # A picture of one's own detections.
    "drawing.found_and_true": "examples/notebooks/attack_a_detector.ipynb",
    # The search over ghosts of a whole set of scenes, in a function.
    "evaluation.ghost_attack": "examples/attack_detections.py",
    # Makes the priors of a YOLO for other objects than cars.
    "perception.detectors.yolo.prior_clusters": "docs/detectors.md",
    # Scenarios as CommonRoad files, for other planners; the commands read them.
    "scenario.commonroad.writing": "docs/planner.md",
    # What a vehicle can say, for an optimiser to search.
    "validation.connected.attacks.lying_vehicle": "docs/connected.md",
    # Attacks on more than one vehicle; those of the command have one victim.
    "validation.connected.attacks.several_victims": "docs/connected.md",
    # The optimised mesh: too slow for the command, a mesher like any other.
    "validation.connected.surfaces.deformed_mesh": "docs/connected.md",
    # Messages between processes of one's own.
    "validation.connected.transport.exchange": "examples/connected_sockets.py",
    "validation.connected.transport.station_port": "examples/connected_sockets.py",
    "validation.connected.transport.vehicle_port": "examples/connected_sockets.py",
}


def reached(begin: list[Path]) -> set[str]:
    """Modules that some files import or name by a string, and so on."""
    return {name for path in begin for name in steps_from(path)}


def product() -> set[str]:
    front = [PACKAGE / "__init__.py", PACKAGE / "__main__.py", PACKAGE / "cli.py"]
    rooms = [path for room in ("commands", "envs") for path in (PACKAGE / room).rglob("*.py")]
    names = {".".join(path.relative_to(ROOT).with_suffix("").parts) for path in front + rooms}
    return names | reached(front + rooms)


def test_every_module_is_reached_or_library_api() -> None:
    library = [PACKAGE / f"{name.replace('.', '/')}.py" for name in LIBRARY]
    kept = product() | {f"avsec_gym.{name}" for name in LIBRARY} | reached(library)
    assert sorted(set(modules()) - kept) == [], (
        "nothing of the product imports these: move them to studies/ or to the tests, or show users"
        " what they are for in docs/, and list them above"
    )


def test_what_the_product_reaches_is_not_listed() -> None:
    assert sorted(product() & {f"avsec_gym.{name}" for name in LIBRARY}) == []


@pytest.mark.parametrize(("name", "place"), LIBRARY.items())
def test_library_api_is_shown_to_users(name: str, place: str) -> None:
    text = (ROOT / place).read_text()
    if place.endswith(".ipynb"):
        text = "".join(line for cell in json.loads(text)["cells"] for line in cell["source"])
    assert f"avsec_gym.{name}" in text
