"""The main job: how safely scenes are driven, with the truth and with detections as input."""
