"""The tables of docs/layouts.md: generated layouts beside KITTI's labels."""

from __future__ import annotations

from avsec_gym.report.markdown_table import markdown_table, number
from avsec_gym.scenario.intention import Intention
from studies.result_fields import field, number_at, value_at

_RESULT = "layout_statistics"
_KINDS = {"wasserstein": "Wasserstein", "variation": "total variation"}
_QUANTITIES = {
    "cars_per_frame": "cars per frame",
    "people_per_frame": "people per frame",
    "category": "category",
    "occlusion": "occlusion level",
    "distance": "distance z",
    "lateral": "lateral position x",
    "heading": "heading",
    "folded_heading": "heading, folded",
    "car_height": "height of cars",
    "car_width": "width of cars",
    "car_length": "length of cars",
    "image_height": "height in the image",
    "truncated_share": "truncated at all",
    "truncation": "truncation where cut",
    "people_distance": "distance z of people",
    "people_lateral": "lateral position x of people",
}
_CATEGORIES = (
    "Car", "Van", "Truck", "Misc", "Pedestrian", "Cyclist", "Person_sitting", "Tram",
)  # fmt: skip
_ROADS = ("street", "highway")


def distances_table() -> list[str]:
    """How far distributions lie from KITTI's, beside two halves of KITTI."""
    rows = []
    for quantity, name in _QUANTITIES.items():
        place = field(_RESULT, "quantities", quantity)
        unit = value_at(place.then("unit"))
        rows.append(
            [
                name,
                _KINDS[str(value_at(place.then("kind")))] + (f", {unit}" if unit else ""),
                number(number_at(place.then("distance")), 4),
                number(number_at(place.then("yardstick")), 4),
            ]
        )
    columns = ["of vehicles, if not stated otherwise", "distance", "generated to KITTI"]
    return markdown_table([*columns, "yardstick"], rows)


def objects_table() -> list[str]:
    """Objects of each category for each frame."""
    rows = [
        [
            category,
            *(
                number(number_at(field(_RESULT, "objects_per_frame", whose, category)), 2)
                for whose in ("kitti", "ours")
            ),
        ]
        for category in _CATEGORIES
    ]
    return markdown_table(["objects per frame", "KITTI", "generated"], rows)


def goals_table() -> list[str]:
    """Shares of scenes whose goal region is covered, left / straight / right, in percent."""
    rows = [[road, *(_covered(road, whose) for whose in ("scenarios", "ours"))] for road in _ROADS]
    return markdown_table(["road type", "labelled scenarios", "generated"], rows)


def _covered(road: str, whose: str) -> str:
    places = (field(_RESULT, "occupied_goals", road, whose, str(way)) for way in Intention)
    return " / ".join(number(100 * (number_at(place) or 0.0), 1) for place in places)
