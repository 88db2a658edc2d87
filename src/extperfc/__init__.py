"""Python side of extperfc: perception that extends a robot's view of its surroundings."""
