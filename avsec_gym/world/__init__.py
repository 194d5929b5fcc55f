"""The procedural look-alike of KITTI: scenes, traffic, cameras, LiDAR from nothing but a seed.

One building with eight doors; what stands outside imports these modules and no others, which a
contract in pyproject.toml checks:

- `layouts`: what stands where at one instant, with KITTI's statistics; scenes without images.
- `assets`: which part of all cars, houses, trees and textures a place is made of.
- `site`: a place without its traffic: the road's course, its cross-section, its surfaces.
- `posed_scenes`: a place built up around a layout or around the labels of a frame.
- `drives`: places with traffic that moves, 10 instants each second.
- `motion`: a scene a little later, and a scene whose vehicle moves.
- `capture`: what the sensors measure in a posed scene: images, scan, labels, depth.
- `export`: data sets on disk: suites, twins, drives and connected vehicles, made, verified, kept.

All the rest is private to the world: its models, textures and kernels change as its looks do.
"""
