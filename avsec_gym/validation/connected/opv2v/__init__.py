"""OPV2V-style folders: a yaml and a pcd of each vehicle at each instant, recorded in CARLA."""
