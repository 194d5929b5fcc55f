"""Primitive files: lossless, and clear about what is broken."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.planners.primitive_files import read_primitives, write_primitives
from avsec_gym.planners.primitives import MotionPrimitives, generate_primitives


@pytest.fixture
def written(tmp_path: Path) -> Path:
    path = tmp_path / "set.xml"
    write_primitives(generate_primitives((6.0,), steering_angles=5), path)
    return path


def test_what_is_written_is_read(tmp_path: Path) -> None:
    primitives = generate_primitives((11.0, 13.0))
    write_primitives(primitives, tmp_path / "set.xml")
    again = read_primitives(tmp_path / "set.xml")
    np.testing.assert_array_equal(again.states, primitives.states)
    np.testing.assert_array_equal(again.steps, primitives.steps)
    assert again.name == "set"
    assert list(tmp_path.iterdir()) == [tmp_path / "set.xml"]
    assert (tmp_path / "set.xml").read_text().startswith("<?xml version='1.0' encoding='utf-8'?>")


def test_short_primitives_keep_their_length(tmp_path: Path) -> None:
    full = generate_primitives((6.0,), steering_angles=5)
    states = full.states.copy()
    states[0, 3:] = states[0, 2]
    steps = full.steps.copy()
    steps[0] = 2
    write_primitives(MotionPrimitives(states, steps), tmp_path / "set.xml")
    again = read_primitives(tmp_path / "set.xml")
    np.testing.assert_array_equal(again.states, states)
    np.testing.assert_array_equal(again.steps, steps)
    np.testing.assert_array_equal(again.ends[0], states[0, 2])


def test_repeated_trajectories_count_once(written: Path) -> None:
    text = written.read_text()
    count = len(read_primitives(written))
    first = re.search(r"<Trajectory>.*?</Trajectory>", text, re.S)
    assert first is not None
    written.write_text(text.replace(first[0], first[0] * 3, 1))
    assert len(read_primitives(written)) == count


def test_nothing_is_overwritten_unasked(written: Path) -> None:
    before = written.read_bytes()
    with pytest.raises(DataError, match="exists"):
        write_primitives(generate_primitives((8.0,)), written)
    assert written.read_bytes() == before
    write_primitives(generate_primitives((8.0,)), written, overwrite=True)
    assert written.read_bytes() != before


@pytest.mark.parametrize(
    ("pattern", "replacement", "message"),
    [
        (r"\Z", None, "well-formed"),
        (r"(?s).*", "", "well-formed"),
        (r"(?s).*", "x,y\n1,2\n", "well-formed"),
        (r"(?s).*", "<a/>", "lacks a <VehicleType>"),
        ("BMW_320i", "FORD_ESCORT", "FORD_ESCORT"),
        (r"(?s)<Trajectory>.*</Trajectory>", "", "no trajectory"),
        (r"(?s)<Final>.*?</Final>", "", "<Trajectory> lacks a <Final>"),
        (r"<velocity>[^<]*</velocity>", "<velocity>fast</velocity>", "<velocity> holds 'fast'"),
        (r"<x>[^<]*</x>", "", "<Initial> lacks a <x>"),
        (r"<y>[^<]*</y>", "<y>nan</y>", "<y> holds 'nan'"),
        (r"<y>[^<]*</y>", "<y>1e999</y>", "<y> holds '1e999'"),
        (r"<y>[^<]*</y>", "<y>1<b>2</b></y>", "<y> holds a <b>"),
        (r"<y>[^<]*</y>", "<y>1</y><y>2</y>", "second <y> in <Initial>"),
        (r"<Final>", "<Final/><Final>", "second <Final>"),
        (r"<Path>", "<Path/><Path>", "second <Path>"),
        (r"(?s)<Trajectory>(.*?)</Trajectory>", r"<Track>\1</Track>", "<Track> is no Traj"),
        (r"(?s)<State>(.*?)</State>", r"<state>\1</state>", "<state> is no State"),
    ],
)
def test_broken_files_are_named(
    written: Path, pattern: str, replacement: str | None, message: str
) -> None:
    text = written.read_text()
    broken = (
        text[: len(text) // 2]
        if replacement is None
        else re.sub(pattern, replacement, text, count=1)
    )
    written.write_text(broken)
    with pytest.raises(DataError, match=message) as caught:
        read_primitives(written)
    assert str(written) in str(caught.value)


def test_missing_file_and_folder(tmp_path: Path) -> None:
    for path in (tmp_path / "absent.xml", tmp_path):
        with pytest.raises(DataError, match=r"no such file|not a file"):
            read_primitives(path)


def test_shared_files(shared: Path) -> None:
    folder = shared / "planning" / "primitives"
    sizes = {path.name: len(read_primitives(path)) for path in folder.glob("*.xml")}
    assert len(sizes) == 3
    assert sizes["street_v6_sa7.xml"] < sizes["highway_v11_13_sa7.xml"] + 1
    for path in folder.glob("*.xml"):
        primitives = read_primitives(path)
        assert (primitives.steps >= 1).all()
        assert (primitives.steps <= 5).all()


PRIMITIVE_FIELDS = ("x", "y", "velocity", "orientation", "steering_angle")


@pytest.mark.parametrize("field", PRIMITIVE_FIELDS)
@pytest.mark.parametrize("place", ["Initial", "Path/State", "Final"])
def test_numbers_that_no_primitive_has(field: str, place: str, tmp_path: Path) -> None:
    path = tmp_path / "some.xml"
    write_primitives(generate_primitives((6.0,), steering_angles=3), path)
    impossible = {"velocity": ["-1", "101"], "steering_angle": ["1.1", "-1.1"]}
    for text in ["nan", "inf", "-inf", "1e300", *impossible.get(field, [])]:
        tree = ElementTree.parse(path)
        found = tree.find(f"Trajectories/Trajectory/{place}/{field}")
        assert found is not None
        found.text = text
        tree.write(tmp_path / "broken.xml")
        with pytest.raises(DataError, match=rf"broken\.xml:.*\b{field}\b"):
            read_primitives(tmp_path / "broken.xml")


@pytest.mark.parametrize("unit", ["second", "", "deci-seconds"])
def test_a_duration_of_another_unit(unit: str, tmp_path: Path) -> None:
    """Five seconds were read as five tenths of one."""
    path = tmp_path / "some.xml"
    write_primitives(generate_primitives((6.0,), steering_angles=3), path)
    tree = ElementTree.parse(path)
    found = tree.find("Trajectories/Trajectory/Duration")
    assert found is not None
    found.set("unit", unit)
    tree.write(path)
    with pytest.raises(DataError, match=r"some\.xml:.*unit of <Duration>.*deci-second"):
        read_primitives(path)
    del found.attrib["unit"]
    tree.write(path)
    read_primitives(path)


@pytest.mark.parametrize(
    ("place", "text"),
    [
        ("Duration", "nan"),
        ("Duration", "-5"),
        ("Duration", "4"),
        ("Duration", "five"),
        ("Initial/time_step", "1"),
        ("Path/State/time_step", "2"),
        ("Path/State/time_step", "nan"),
        ("Final/time_step", "50"),
        ("Final/time_step", "4.5"),
    ],
)
def test_times_that_no_primitive_has(place: str, text: str, tmp_path: Path) -> None:
    path = tmp_path / "some.xml"
    write_primitives(generate_primitives((6.0,), steering_angles=3), path)
    tree = ElementTree.parse(path)
    found = tree.find(f"Trajectories/Trajectory/{place}")
    assert found is not None
    found.text = text
    tree.write(path)
    with pytest.raises(DataError, match=rf"some\.xml:.*<{place.split('/')[-1]}>"):
        read_primitives(path)


def test_times_may_be_left_out(tmp_path: Path) -> None:
    path = tmp_path / "some.xml"
    written = generate_primitives((6.0,), steering_angles=3)
    write_primitives(written, path)
    tree = ElementTree.parse(path)
    for parent in list(tree.iter()):
        for child in [child for child in parent if child.tag in ("Duration", "time_step")]:
            parent.remove(child)
    tree.write(path)
    np.testing.assert_array_equal(read_primitives(path).steps, written.steps)


def test_declarations_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "some.xml"
    write_primitives(generate_primitives((6.0,), steering_angles=3), path)
    declared = '<!DOCTYPE M [<!ENTITY a "6.0">]>\n<MotionPrimitiveFile'
    path.write_text(path.read_text().replace("<MotionPrimitiveFile", declared, 1))
    with pytest.raises(DataError, match=r"some\.xml:\d+: .*declares"):
        read_primitives(path)


@pytest.mark.parametrize("place", ["Initial", "Path/State", "Final"])
@pytest.mark.parametrize("field", ["x", "y"])
def test_states_farther_apart_than_the_vehicle_drives(
    place: str, field: str, tmp_path: Path
) -> None:
    path = tmp_path / "some.xml"
    write_primitives(generate_primitives((6.0,), steering_angles=3), path)
    tree = ElementTree.parse(path)
    found = tree.find(f"Trajectories/Trajectory/{place}/{field}")
    assert found is not None
    found.text = str(float(found.text or 0) + (-0.45 if place == "Initial" else 0.45))
    tree.write(path)
    with pytest.raises(DataError, match=r"some\.xml:.*trajectory 1 moves by .* at 6 m/s"):
        read_primitives(path)


def test_the_step_that_leads_farthest_is_named(tmp_path: Path) -> None:
    path = tmp_path / "some.xml"
    write_primitives(generate_primitives((6.0,), steering_angles=3), path)
    tree = ElementTree.parse(path)
    states = tree.findall("Trajectories/Trajectory[1]/Path/State/x")
    for number, farther in ((1, 0.1), (2, 1.5), (3, 1.4)):
        states[number].text = str(float(states[number].text or 0) + farther)
    tree.write(path)
    # State 0 is the initial one: the third of the path is state 3, and 1.4 m farther come before.
    with pytest.raises(DataError, match="from state 2 to the next one, at 6 m/s"):
        read_primitives(path)
