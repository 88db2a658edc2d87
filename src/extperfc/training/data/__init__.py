"""Labelled images: reading Pascal VOC folders and COCO files, checking, splitting, augmenting."""

from .dataset import DataError, Dataset, Problem, Sample
from .reading import read_dataset, scan

__all__ = ["DataError", "Dataset", "Problem", "Sample", "read_dataset", "scan"]
