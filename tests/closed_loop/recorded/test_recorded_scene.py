from __future__ import annotations

import numpy as np

from avsec_gym.closed_loop.recorded.recorded_scene import recorded_scene
from avsec_gym.closed_loop.recorded.windows import known_motion
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention

from .made_traffic import driving, motion, parked, traffic

LEADER, ONCOMING = driving(15.0, 0.0, 9.0), driving(120.0, 3.5, -8.0)
KNOWN = known_motion(traffic(motion(9.0), [LEADER, ONCOMING, *parked()], known=True))


def test_actors_are_where_the_labels_have_them() -> None:
    scene = recorded_scene(KNOWN, 10)
    tracks = scene.tracks
    x, y, heading, speed = tracks.state(0, 4.0)
    # Ten frames after the first the car has driven 9 m.
    assert np.allclose(
        (x, y, heading, speed), (15.0 + 0.1 * 9.0 * 50 - 9.0, 0.0, 0.0, 9.0), atol=0.05
    )
    assert (tracks.speeds[2:] == 0).all()
    assert np.allclose(tracks.poses[2, :, 0], 10.0 - 9.0, atol=0.05)


def test_what_comes_into_view_was_there_before() -> None:
    """A mover's labels end where it leaves the view: it drives on for two seconds."""
    tracks = recorded_scene(KNOWN, 0).tracks
    labelled = next(each for each in KNOWN.recording.objects if each.id == 1).frames
    assert tracks.last[1] == labelled[-1] + 20
    assert tracks.first[1] == max(labelled[0] - 20, 0)
    end = tracks.poses[1, tracks.last[1]]
    assert np.allclose(end[:2], ONCOMING[0, :2] - (0.8 * tracks.last[1], 0.0), atol=0.1)


def test_the_road_and_the_start_are_the_recorded_cars() -> None:
    scene = recorded_scene(KNOWN, 0)
    assert scene.start.velocity == 9.0
    assert scene.cruise == (9.0, 11.0)
    assert scene.road_type == RoadType.STREET
    assert scene.id == "made-000000"
    # The oncoming car shows where the left lane leads.
    assert scene.intentions == (Intention.STRAIGHT, Intention.RIGHT)


def test_people_can_be_left_out() -> None:
    scene = recorded_scene(KNOWN, 0, people=False)
    assert len(scene.tracks) == len(recorded_scene(KNOWN, 0).tracks)


def test_nothing_is_extended_into_the_recorded_car() -> None:
    """A car that is first labelled beside the car came from behind it, not through it."""
    ego = motion(9.0)
    cut = driving(4.0, 0.0, 12.0)
    seen = known_motion(traffic(ego, [cut], known=True))
    tracks = recorded_scene(seen, 20).tracks
    for step in range(int(tracks.first[0]), 21):
        x, _, _, _ = tracks.state(0, 0.1 * step)
        assert x - 9.0 * 0.1 * step > 4.3
