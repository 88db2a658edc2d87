"""Supervision of the robot's parts: which are alive, which hang, and the tree of their diagnostics."""
