"""Splits into train, val and test by seed: stratified by class, images that look alike stay together.

Stratification: Sechidis, Tsoumakas, Vlahavas, "On the stratification of multi-label data" (ECML 2011), algorithm 1,
over groups of images instead of images.
"""

import json

import numpy as np

from ..text_files import write_text_atomically
from . import coco, voc
from .dataset import DataError
from .fingerprints import fingerprint, groups_of, near_pairs

FRACTIONS = {"train": 0.7, "val": 0.2, "test": 0.1}


def split_names(dataset, seed, fractions=None, pairs=None):
    """Names of samples by split: {split: tuple of names in the set's order}.

    fractions: of the images, by split; they sum to 1. pairs: of indices of samples that must stay together, those that
    look alike by default. The same samples, fractions and seed give the same splits.
    """
    fractions = fractions or FRACTIONS
    if any(f <= 0 for f in fractions.values()) or abs(sum(fractions.values()) - 1) > 1e-6:
        raise DataError(f"fractions of the splits must be positive and sum to 1, not {fractions}")
    if pairs is None:
        pairs = near_pairs([fingerprint(sample.image) for sample in dataset.samples])
    groups = groups_of(len(dataset), pairs)
    if len(groups) < len(fractions):
        raise DataError(
            f"{dataset.root}: {len(groups)} images that differ cannot fill {len(fractions)} splits: record more")
    home = assign(group_counts(dataset, groups), np.array(list(fractions.values())), np.random.default_rng(seed))
    names = {split: [] for split in fractions}
    for split, group in sorted(((list(fractions)[home[g]], i) for g, group in enumerate(groups) for i in group),
                               key=lambda item: item[1]):
        names[split].append(dataset.samples[group].name)
    return {split: tuple(members) for split, members in names.items()}


def group_counts(dataset, groups):
    """Objects of each class, then images, of each group: [groups, classes + 1]."""
    counts = np.zeros((len(groups), len(dataset.class_names) + 1))
    for row, group in enumerate(groups):
        for i in group:
            counts[row, :-1] += np.bincount(dataset.samples[i].labels, minlength=len(dataset.class_names))
        counts[row, -1] = len(group)
    return counts


def assign(counts, fractions, rng):
    """The split of each group. The rarest class still to be placed goes first, to the split that lacks it most."""
    needed = fractions[:, None] * counts.sum(0)  # [splits, classes + 1]
    home = np.full(len(counts), -1)
    order = rng.permutation(len(counts))
    while (home < 0).any():
        left = counts[home < 0].sum(0)
        column = int(np.argmin(np.where(left[:-1] > 0, left[:-1], np.inf))) if (left[:-1] > 0).any() else -1
        members = [g for g in order if home[g] < 0 and (column < 0 or counts[g, column] > 0)]
        for group in sorted(members, key=lambda g: -counts[g, column]):
            best = max(range(len(fractions)), key=lambda s: (needed[s, column], needed[s, -1]))
            home[group] = best
            needed[best] -= counts[group]
    return fill_empty(home, counts, len(fractions))


def fill_empty(home, counts, splits):
    """A split that got no group takes the smallest one of the split with the largest number of groups."""
    for split in range(splits):
        if not (home == split).any():
            giver = np.bincount(home, minlength=splits).argmax()
            members = np.flatnonzero(home == giver)
            home[members[counts[members, -1].argmin()]] = split
    return home


def write_splits(dataset, names, seed, replace=False):
    """Writes the splits beside the labels; returns the files. DataError when there are some and `replace` is false.

    Pascal VOC: ImageSets/Main/SPLIT.txt and trainval.txt. COCO: STEM_SPLIT.json beside STEM.json.
    """
    is_voc = dataset.root.is_dir() and voc.is_voc_folder(dataset.root)
    files = voc_contents(dataset, names, seed) if is_voc else coco_contents(dataset, names)
    there = [file for file in files if file.exists()]
    if there and not replace:
        raise DataError(f"{there[0]} is there already: give --replace to write over the splits of {dataset.root}")
    for file, text in files.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        write_text_atomically(text, file)
    return list(files)


def voc_contents(dataset, names, seed):
    folder = dataset.root / "ImageSets" / "Main"
    files = {folder / f"{split}.txt": "".join(f"{n}\n" for n in members) for split, members in names.items()}
    joined = sorted([*names.get("train", ()), *names.get("val", ())])
    files[folder / "trainval.txt"] = "".join(f"{n}\n" for n in joined)
    files[folder / "splits.json"] = json.dumps(
        {"seed": seed, "images": {split: len(members) for split, members in names.items()},
         "data_sha256": dataset.checksum()}, indent=1) + "\n"
    return files


def coco_contents(dataset, names):
    """COCO's splits are files of their own; the set must be a single file."""
    files = [dataset.root
             ] if dataset.root.is_file() else [f for f in coco.coco_files(dataset.root) if coco.is_coco_file(f)]
    if len(files) != 1:
        raise DataError(f"{dataset.root}: {len(files)} COCO files; give the one to split by its path")
    content = json.loads(files[0].read_text())
    home = {name: split for split, members in names.items() for name in members}
    stem_of = {image["id"]: image["file_name"].rsplit(".", 1)[0] for image in content["images"]}
    written = {}
    for split in names:
        ids = {i for i, stem in stem_of.items() if home.get(stem) == split}
        part = dict(content, images=[i for i in content["images"] if i["id"] in ids],
                    annotations=[a for a in content["annotations"] if a["image_id"] in ids])
        written[files[0].with_name(f"{files[0].stem}_{split}.json")] = json.dumps(part) + "\n"
    return written
