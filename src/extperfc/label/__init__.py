"""Labelling of images with boxes: the model, without a window, and the PyQt5 window of tools/extperfc-label.

  boxes, voc, coco, folder    boxes and their files
  document                    the images of a folder, changes with undo, and what is saved when
  statistics, filters         counts, and which images the list shows
  model_folder, detector      boxes that a network proposes
  shortcuts                   the table of keys
  window, canvas, ...         the window; only these import PyQt5
"""
