"""What several rooms need of the disk: the one door through which files are read."""
