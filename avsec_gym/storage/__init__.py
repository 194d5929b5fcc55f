"""What several rooms need of the disk: whole writes, strict reading through one door, locks."""
