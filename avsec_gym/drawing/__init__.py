"""Pictures that environments, commands and studies share: frames, scenes, drives, curves."""
