"""Training of the small shape detector (cone, cube, sphere) on generated images."""
