"""A film in a file, and what it answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.closed_loop.drive_film import DriveFilm, read_film
from avsec_gym.errors import DataError


def film() -> DriveFilm:
    """Two seconds straight ahead at 10 m/s; one actor ahead, which is believed in at first."""
    times = np.arange(21) / 10
    car = np.zeros((21, 5))
    car[:, 0], car[:, 2] = 10.0 * times, 10.0
    poses = np.zeros((21, 1, 3))
    poses[:, 0, 0] = 30.0
    side = np.array([[-50.0, 2.0], [100.0, 2.0]])
    return DriveFilm(
        times=times,
        car=car,
        braking=np.zeros(21),
        ways=np.zeros(21),
        sizes=np.array([[4.0, 2.0]]),
        poses=poses,
        present=np.ones((21, 1), bool),
        believed=np.array([[30.0, 0.0, 0.0, 4.0, 2.0]]),
        believed_at=np.array([0]),
        plans=np.column_stack([np.arange(30.0), np.zeros(30)]),
        plan_of=np.zeros(30, int),
        planned=np.zeros(21, int),
        stops=np.zeros(21, bool),
        bounds=np.vstack([side, side * (1, -1)]),
        bound_of=np.array([0, 0, 1, 1]),
        goal=np.array([[40.0, 2.0], [40.0, -2.0]]),
        contact=np.array([-1]),
    )


def test_a_film_comes_back_as_it_was(tmp_path: Path) -> None:
    given = film()
    (tmp_path / "film.npz").write_bytes(given.content())
    back = read_film(tmp_path / "film.npz")
    for each in fields(DriveFilm):
        np.testing.assert_allclose(getattr(back, each.name), getattr(given, each.name), atol=1e-4)
    assert back.content() == given.content()


def test_a_damaged_film_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "film.npz"
    path.write_bytes(film().content()[:-40])
    with pytest.raises(DataError, match="--resume"):
        read_film(path)
    path.write_bytes(replace(film(), times=np.zeros(3)).content())
    with pytest.raises(DataError, match="no film"):
        read_film(path)


def test_an_instant_by_its_time() -> None:
    assert [film().at(time) for time in (0.0, 0.99, 1.0, 7.0)] == [0, 9, 10, 20]


def test_a_lane_is_between_its_bounds() -> None:
    (lane,) = film().lanes()
    assert lane.tolist() == [[-50, 2], [100, 2], [100, -2], [-50, -2]]


def _changed(name: str, change: Callable[[Any], Any]) -> dict[str, Any]:
    arrays = {each.name: getattr(film(), each.name) for each in fields(DriveFilm)}
    return {**arrays, name: change(arrays[name])}


def _set(index: Any, value: Any) -> Callable[[Any], Any]:
    def change(array: Any) -> Any:
        array = array.copy()
        array[index] = value
        return array

    return change


@pytest.mark.parametrize("name", [each.name for each in fields(DriveFilm)])
@pytest.mark.parametrize(
    "change",
    [
        lambda array: array.astype("U8"),
        lambda array: array.astype(complex),
        lambda array: array.astype("u1"),
        lambda array: array[None],
        lambda array: array[..., None],
        lambda array: array.reshape(-1)[:0],
        lambda array: np.array(1.0),
    ],
    ids=["text", "complex", "bytes", "first axis", "last axis", "empty", "scalar"],
)
def test_each_array_is_of_its_kind_and_shape(
    name: str, change: Callable[[Any], Any], tmp_path: Path
) -> None:
    path = tmp_path / "film.npz"
    arrays = _changed(name, change)
    np.savez(path, **arrays)
    with pytest.raises(DataError, match=r"film\.npz: .*(no film of a drive|no plain array)"):
        read_film(path)


@pytest.mark.parametrize(
    ("name", "index", "value", "problem"),
    [
        *(
            (each, 0, value, "not finite")
            for each in ("times", "car", "braking", "ways", "sizes", "poses", "believed", "goal")
            for value in (np.nan, np.inf)
        ),
        ("bounds", (1, 0), 1e300, "farther away"),
        ("poses", (2, 0, 1), -1e6, "farther away"),
        *(
            (each, -1, value, "no drive has|farther away|no car can|one after the other")
            for each in ("times", "car", "braking", "ways", "sizes", "poses", "believed", "goal")
            for value in (1e30, -1e30)
        ),
        *(("car", (0, each), 1e30, "no drive has") for each in (2, 3, 4)),
        ("poses", (2, 0, 2), -1e30, "no drive has"),
        *(("believed", (0, each), 1e30, "no drive has") for each in (2, 3, 4)),
        ("sizes", (0, 1), -0.1, "smaller than nothing"),
        ("believed", (0, 3), -0.1, "smaller than nothing"),
        ("braking", 2, 2e3, "no car can"),
        ("times", 3, 0.1, "one after the other"),
        ("times", 20, 1e9, "one after the other"),
        ("times", 0, -1.0, "one after the other"),
        ("bound_of", 3, 3, "lacks a bound"),
        ("bound_of", slice(2, None), 0, "lacks a bound"),
        ("believed_at", 0, 21, "believed_at names"),
        ("believed_at", 0, -1, "believed_at names"),
        ("planned", 4, 10**12, "planned names"),
        ("plan_of", 4, -1, "plan_of names"),
        ("contact", 0, 1, "contact names"),
        ("contact", 0, -2, "contact names"),
    ],
)
def test_numbers_are_those_of_a_drive(
    name: str, index: Any, value: float, problem: str, tmp_path: Path
) -> None:
    path = tmp_path / "film.npz"
    np.savez(path, **_changed(name, _set(index, value)))
    with pytest.raises(DataError, match=problem):
        read_film(path)
