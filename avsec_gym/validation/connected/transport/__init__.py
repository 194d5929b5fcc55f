"""Vehicles and base station as processes of their own, over sockets of this machine."""
