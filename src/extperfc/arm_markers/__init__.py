"""Arms in rviz: goals to drag, a ghost of the arm that reaches them, and planned paths as moving ghosts."""
