"""Vehicles: cars, vans, lorries, buses, trams, trailers, each from a size and a seed."""

from avsec_gym.world.models.vehicles.body_design import BodyDesign
from avsec_gym.world.models.vehicles.designs import body_designs
from avsec_gym.world.models.vehicles.vehicle import make_ego_vehicle, make_vehicle

__all__ = ["BodyDesign", "body_designs", "make_ego_vehicle", "make_vehicle"]
