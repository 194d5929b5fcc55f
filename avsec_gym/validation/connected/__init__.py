"""Connected vehicles compare their LiDAR scans, and find the one that was spoofed (chapter 4)."""
