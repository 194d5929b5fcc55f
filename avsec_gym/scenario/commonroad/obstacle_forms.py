"""The forms in which CommonRoad files write obstacles, brought to those that commonroad-io reads.

Format 2018b has ``<obstacle>`` with a ``<role>``, format 2020a an element for each role, and
commonroad-io passes over those of the other format.  An ``<environmentObstacle>`` is a building or
a pillar that stands where its shape places it.
"""

from __future__ import annotations

from avsec_gym.storage.xml_tree import Element

VERSIONS = ("2018b", "2020a")
_ROLES = ("static", "dynamic")


def with_named_roles(root: Element) -> Element:
    """The tree with ``<staticObstacle>`` and ``<dynamicObstacle>`` for ``<obstacle>``.

    Raises:
        DataError: An obstacle has no such role, or is a set of places where something may be.
    """
    return root._replace(children=[_with_named_role(child) for child in root.children])


def _with_named_role(element: Element) -> Element:
    for uncertain in (element, *element.children):
        if uncertain.name in ("phantomObstacle", "occupancySet"):
            uncertain.refuse(
                f"{uncertain.tag} holds places where something may be; the planner needs to know"
                " where it is.",
                "Write a dynamicObstacle with a trajectory.",
            )
    if element.name != "obstacle":
        return element
    role = element.child("role")
    if role.text not in _ROLES:
        role.refuse(
            f"{element.tag} has the role {role.text[:40]!r}.", f"Expected {' or '.join(_ROLES)}."
        )
    others = [child for child in element.children if child is not role]
    return element._replace(name=f"{role.text}Obstacle", children=others)


def as_read(root: Element) -> Element:
    """The tree as commonroad-io reads files of its version.

    Args:
        root: A checked tree of `with_named_roles`.

    Raises:
        DataError: commonroad-io does not read the version.
    """
    version = root.attributes.get("commonRoadVersion", "")
    if version not in VERSIONS:
        root.refuse(
            f"commonRoadVersion is {version[:40]!r}.", f"Write format {' or '.join(VERSIONS)}."
        )
    children = [_standing(child) for child in root.children]
    if version == "2018b":
        children = [_with_a_role(child) for child in children]
    return root._replace(children=children)


def _standing(element: Element) -> Element:
    """An environment obstacle as a static one; all else as it is."""
    if element.name != "environmentObstacle":
        return element

    def new(name: str, *children: Element, text: str = "") -> Element:
        return Element(name, element.line, element.path, {}, list(children), [text])

    zero = new("exact", text="0")
    origin = new("point", new("x", text="0"), new("y", text="0"))
    state = new(
        "initialState",
        new("position", origin),
        new("orientation", zero),
        new("time", zero),
        new("velocity", zero),
    )
    return element._replace(name="staticObstacle", children=[*element.children, state])


def _with_a_role(element: Element) -> Element:
    role = element.name.removesuffix("Obstacle")
    if role not in _ROLES or role == element.name:
        return element
    first = Element("role", element.line, element.path, {}, [], [role])
    return element._replace(name="obstacle", children=[first, *element.children])
