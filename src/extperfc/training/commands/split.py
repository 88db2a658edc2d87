"""splits labelled images into train, val and test

By seed, stratified by class; images that look alike stay together. Writes ImageSets/Main/*.txt of a Pascal VOC folder,
or NAME_train.json, NAME_val.json, NAME_test.json beside a COCO file.
"""

import pathlib


def add_arguments(parser):
    parser.add_argument("data", type=pathlib.Path, help="Pascal VOC folder or COCO file")
    parser.add_argument("--seed", type=int, default=1, help="the same seed gives the same splits (default: 1)")
    parser.add_argument("--fractions", type=float, nargs=3, default=(0.7, 0.2, 0.1), metavar=("TRAIN", "VAL", "TEST"),
                        help="of the images (default: 0.7 0.2 0.1)")
    parser.add_argument("--replace", action="store_true", help="write over splits that are there")


def run(options):
    from ..data import read_dataset
    from ..data.splits import split_names, write_splits
    dataset = read_dataset(options.data)
    names = split_names(dataset, options.seed, dict(zip(("train", "val", "test"), options.fractions)))
    files = write_splits(dataset, names, options.seed, options.replace)
    for split, members in names.items():
        chosen = set(members)
        counts = [sum(int((s.labels == i).sum()) for s in dataset.samples if s.name in chosen)
                  for i in range(len(dataset.class_names))]
        shown = ", ".join(f"{name} {count}" for name, count in zip(dataset.class_names, counts))
        print(f"{split}: {len(members)} images; {shown}")
    print("wrote " + ", ".join(str(file) for file in files))
    return 0
