"""The frozen benchmark: scene sets, the protocol of each kind of entry, entries, leaderboard.

An entry is the pipeline with one part taken out: the entered detector, attack, validator or planner
stands in its place, and all other parts are those of the version.  `scene_sets` holds the scenes of
single queries, `protocol` what is done in them, `episodes` does it; `loop_scenes`, `loop_protocol`
and `loop_drives` are the same of the closed loop, `connected_scenes` and `connected_instants` of
several vehicles.  `making` makes an entry, `entry` is the result, `leaderboard` compares entries.
"""
