"""What a picture of a drive shows, where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.closed_loop.drive_film import DriveFilm
from avsec_gym.drawing.film_picture import CONTACT, GROUND, UNSEEN, FilmView, film_picture
from avsec_gym.drawing.film_strip import ShownDrive, clip, film_strip, gif, strip_instants
from avsec_gym.drawing.scenario_picture import BELIEVED, EGO, GOAL, REAL, ROAD

VIEW = FilmView((300, 60), 5.0, "right", 10.0)


def film(contact: int = -1) -> DriveFilm:
    """Two seconds straight ahead at 10 m/s; a box stands 30 m ahead, believed in at first only."""
    times = np.arange(21) / 10
    car = np.zeros((21, 5))
    car[:, 0], car[:, 2] = 10.0 * times, 10.0
    poses = np.zeros((21, 1, 3))
    poses[:, 0, 0] = 30.0
    side = np.array([[-50.0, 3.0], [100.0, 3.0]])
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
        plans=np.zeros((0, 2)),
        plan_of=np.zeros(0, int),
        planned=np.full(21, -1),
        stops=np.zeros(21, bool),
        bounds=np.vstack([side, side * (1, -1)]),
        bound_of=np.array([0, 0, 1, 1]),
        goal=np.array([[40.0, 3.0], [40.0, -3.0]]),
        contact=np.array([contact]),
    )


def at(picture: np.ndarray, ahead: float, left: float) -> str:
    """The colour of a place by the car, in the view that looks to the right."""
    row, column = round(30 - 5 * left), round(5 * (10 + ahead))
    return "#" + "".join(f"{value:02x}" for value in picture[row, column])


def test_everything_lies_where_it_is() -> None:
    picture = film_picture(film(), 0, VIEW)
    assert picture.shape == (60, 300, 3)
    assert at(picture, 0.0, 0.0) == EGO
    assert at(picture, 30.0, 0.0) == REAL
    assert at(picture, 40.0, 1.5) == GOAL
    assert at(picture, 10.0, 1.5) == ROAD
    assert at(picture, 10.0, 5.0) == GROUND
    # A second later everything is 10 m nearer.
    assert at(film_picture(film(), 10, VIEW), 30.0, 1.5) == GOAL


def test_up_is_ahead_and_left_is_left() -> None:
    seen = replace(film(), poses=np.add(film().poses, [0.0, 4.0, 0.0]))
    picture = film_picture(seen, 10, FilmView((60, 300), 5.0, "up", 10.0))
    # 20 m ahead and 4 m to the left of a car 10 m from the lower edge.
    assert tuple(picture[300 - 5 * 30, 30 - 5 * 4]) == tuple(bytes.fromhex(UNSEEN[1:]))


def test_what_the_car_does_not_believe_in_is_white_and_what_it_touched_red() -> None:
    assert at(film_picture(film(), 10, VIEW), 20.0, 0.0) == UNSEEN
    assert at(film_picture(film(contact=0), 20, VIEW), 10.0, 0.0) == CONTACT
    assert at(film_picture(film(contact=0), 10, VIEW), 20.0, 0.0) == UNSEEN


def test_only_what_is_believed_otherwise_is_dashed() -> None:
    red = np.array(list(bytes.fromhex(BELIEVED[1:])))
    ghost = replace(film(), believed=np.array([[15.0, 0.0, 0.0, 4.0, 2.0]]))
    for given, drawn in ((film(), False), (ghost, True)):
        picture = film_picture(given, 0, VIEW)
        # Thin lines are smoothed: nearly that colour.
        assert bool((np.abs(picture - red).max(axis=-1) < 40).any()) == drawn


@pytest.mark.parametrize(("every", "instants"), [(1, [0, 10, 20]), (2, [0, 20])])
def test_a_strip_has_each_second_and_the_end(every: int, instants: list[int]) -> None:
    assert strip_instants(film(), every) == instants
    shown = ShownDrive("truth", film(), "goal", False)
    wide, narrow = film_strip(shown, 5), film_strip(shown, 3)
    assert wide.shape[1] > narrow.shape[1]
    np.testing.assert_array_equal(wide[:, : narrow.shape[1]], narrow)


def test_a_clip_waits_for_the_longest_drive() -> None:
    whole, cut = film(), film()
    cut = replace(cut, times=cut.times[:5], car=cut.car[:5], braking=cut.braking[:5])
    images = clip(
        [ShownDrive("truth", whole, "goal", False), ShownDrive("blind", cut, "collision", True)]
    )
    assert len(images) > 21
    half = images[0].shape[0] // 2
    np.testing.assert_array_equal(images[6][half:], images[20][half:])
    assert (images[6][:half] != images[20][:half]).any()
    assert gif(images).startswith(b"GIF89a")
