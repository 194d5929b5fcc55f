"""A film in a file, and what it answers."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

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
