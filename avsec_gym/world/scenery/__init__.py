"""What stands beside the road: houses, plants, street furniture, placed by style."""
