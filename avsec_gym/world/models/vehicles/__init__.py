"""Vehicles: cars, vans, lorries, buses, trams, trailers, each from a size and a seed."""

from avsec_gym.world.models.vehicles.vehicle import make_ego_vehicle, make_vehicle

__all__ = ["make_ego_vehicle", "make_vehicle"]
