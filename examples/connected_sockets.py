"""Four vehicles and a base station, a process each, on bad lines: whose LiDAR has a ghost?

python examples/connected_sockets.py [--lost 0.1] [--doubled 0.2] [--malformed 0.1] [--seconds 10]
"""

from multiprocessing import get_context

import tyro
from plain_with_cars import PLACES, is_ghost, scan_of

from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.transport.exchange import judge_instant, take_part
from avsec_gym.validation.connected.transport.station_port import StationPort
from avsec_gym.validation.connected.transport.vehicle_port import Faults, VehiclePort


def drive(port: int, faults: Faults, seed: int) -> None:
    line, margins = VehiclePort(port, faults, seed), read_connected_fit(SHIPPED_FIT).margins
    for instant in range(5):
        take_part(line, instant, scan_of(line.number), ClusterProposer(), 30, margins)
    line.receive(30)  # Until the base station leaves.


def main(faults: Faults, seconds: float = 3.0) -> None:
    with StationPort(len(PLACES)) as station:
        for seed in range(len(PLACES)):
            process = get_context("spawn").Process
            process(target=drive, args=(station.number, faults, seed), daemon=True).start()
        station.join(60)
        constants = read_connected_fit(SHIPPED_FIT).constants()
        for instant in range(5):  # It waits `seconds` for what is missing, at each of three steps.
            outcome = judge_instant(station, instant, seconds, constants)
            named = outcome.named[is_ghost(outcome.regions.centre)]
            print(f"{instant}: heard {outcome.heard}, named at the ghost {named}")
        print(f"left out: {dict(station.tally)}")


if __name__ == "__main__":
    tyro.cli(main, config=(tyro.conf.OmitArgPrefixes,))
