"""The edges of a box in an image."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.drawing.box_edges import edges_in_image
from avsec_gym.geometry import Floats, box_corners, project

PINHOLE = np.array([[700.0, 0.0, 600.0, 0.0], [0.0, 700.0, 180.0, 0.0], [0.0, 0.0, 1.0, 0.0]])


def corners_at(z: float, length: float = 4.0) -> Floats:
    location = np.array([[1.0, 1.5, z]])
    corners: Floats = box_corners(location, np.array([[1.5, 1.6, length]]), np.array([0.3]))[0]
    return corners


def test_all_twelve_edges_are_drawn_between_their_corners() -> None:
    corners = corners_at(20.0)
    pixels, _ = project(PINHOLE, corners)
    lengths = np.linalg.norm(corners[:, None] - corners[None], axis=-1)
    # An edge is as long as one of the box's three sides.
    sides = [1.5, 1.6, 4.0]
    expected = {
        frozenset(map(tuple, np.round(pixels[[i, j]], 6)))
        for i in range(8)
        for j in range(i)
        if np.isclose(lengths[i, j], sides, atol=1e-6).any()
    }
    drawn = {frozenset(map(tuple, np.round(edge, 6))) for edge in edges_in_image(corners, PINHOLE)}
    assert len(expected) == 12
    assert drawn == expected


def test_an_edge_that_passes_the_camera_is_cut_before_it() -> None:
    whole, cut = corners_at(20.0), corners_at(1.0)
    assert cut[:, 2].min() < 0 < cut[:, 2].max()
    edges = list(edges_in_image(cut, PINHOLE))
    assert 0 < len(edges) < len(list(edges_in_image(whole, PINHOLE)))
    assert np.isfinite(edges).all()
    # What is cut ends 0.3 m before the camera, where a metre is 700 / 0.3 pixels.
    cut_ends = [near for near, far in edges if abs(near[0] - far[0]) > 700]
    assert cut_ends
    assert max(abs(u - 600) for u, _ in cut_ends) <= 700 / 0.3 * np.abs(cut[:, 0]).max() + 1e-6


@pytest.mark.parametrize("z", [-10.0, -3.0])
def test_a_box_behind_the_camera_has_none(z: float) -> None:
    assert list(edges_in_image(corners_at(z), PINHOLE)) == []
