"""Half of the machine's memory, by what the kernel says of it."""

import pytest

from avsec_gym.machine_memory import half_of_memory


def test_half_of_the_machine_s_memory() -> None:
    with open("/proc/meminfo") as facts:
        total = 1024 * int(facts.readline().split()[1])
    assert half_of_memory() == pytest.approx(total / 2, rel=0.01)
