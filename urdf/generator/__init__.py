"""Parts of urdf/generate.py: figures of the robot, solids, what links look like, the description's text."""
