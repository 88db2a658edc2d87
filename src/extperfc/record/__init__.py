"""Recording of RGB-D images for training: what tools/extperfc-record is made of.

  frames       images and intrinsics as the sources deliver them
  topics, bag, camera    the sources
  near_duplicates        which images are worth keeping
  folder       the folder that is written
  recorder     joins them: one frame after another, on key press or at intervals
"""
