"""PIXOR (Yang, Luo and Urtasun, CVPR 2018): cars from a LiDAR scan seen from above."""
