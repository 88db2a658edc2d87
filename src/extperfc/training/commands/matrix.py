"""trains all networks with all three strategies and compares them, as the ExtPerFC paper does

Trains a source model per network, then random weights, feature-representation transfer and instance transfer on the
target images; evaluates every run on the test split; writes matrix.md, matrix.json, ap_over_iou.png and
validation_loss.png. Started again with the same output it goes on where it ended. --smoke does all of it in minutes on
two cores, on drawn images: it shows that everything works, not how good the networks are.
"""

import pathlib

NETWORKS = ("mobilenet_v1_ssd", "mobilenet_v2_ssd_lite", "squeezenet_ssd_lite", "vgg16_ssd", "yolov7_tiny_320")
STRATEGIES = ("random_weights", "feature_representation_transfer", "instance_transfer")
SMOKE = {"epochs": 1, "warmup_epochs": 0, "batch_size": 2, "max_steps": 2, "workers": 0, "average_decay": 0.5,
         "keep_checkpoints": 1}
SMOKE_IMAGES = {"source": 10, "target": 15}
DRAWN_IMAGES = {"source": 8000, "target": 2000}
DOMAINS = {"source": "household", "target": "solids"}


def add_arguments(parser):
    parser.add_argument("--data",
                        type=pathlib.Path,
                        help="target images with splits train, val, test; default: drawn ones")
    parser.add_argument("--source-data", type=pathlib.Path, help="source images, of other classes; default: drawn ones")
    parser.add_argument("--output", type=pathlib.Path, default=pathlib.Path("matrix"), help="folder (default: matrix)")
    parser.add_argument("--networks",
                        nargs="+",
                        default=NETWORKS,
                        metavar="NAME",
                        help=f"default: {' '.join(NETWORKS)}")
    parser.add_argument("--strategies", nargs="+", default=STRATEGIES, choices=STRATEGIES, metavar="NAME",
                        help=f"default: {' '.join(STRATEGIES)}")
    parser.add_argument("--epochs", type=int, default=100, help="of each target run (default: 100)")
    parser.add_argument("--source-epochs", type=int, default=60, help="of each source model (default: 60)")
    parser.add_argument("--validate-epochs", type=int, default=1, help="epochs between validations (default: 1)")
    parser.add_argument("--batch-size", type=int, default=32, help="images per step (default: 32)")
    parser.add_argument("--workers", type=int, default=8, help="processes that read images (default: 8)")
    parser.add_argument("--jobs",
                        type=int,
                        default=1,
                        help="networks trained at a time, each in a process of its own (default: 1)")
    parser.add_argument("--device", default="auto", help="auto, cpu, cuda or cuda:N (default: auto)")
    parser.add_argument("--fast", action="store_true",
                        help="on a GPU: the fastest operations, which are not repeatable to the bit")
    parser.add_argument("--seed", type=int, default=1, help="of weights, order and augmentation (default: 1)")
    parser.add_argument("--smoke", action="store_true", help="a moment of each run on a few drawn images")


def run(options):
    from ..matrix import run_matrix
    from ..networks import NETWORKS as known
    from ..errors import SettingsError
    unknown = [name for name in options.networks if name not in known]
    if unknown:
        raise SettingsError(f"unknown networks: {', '.join(unknown)}; there are {', '.join(known)}")
    if options.jobs < 1:
        raise SettingsError(f"--jobs {options.jobs}: give 1 or more")
    run_matrix(make_plan(options), jobs=options.jobs)
    print((options.output / "matrix.md").read_text())
    return 0


def make_plan(options):
    """The plan of a command line; draws the images that it lacks."""
    from ..matrix import Plan
    data = {
        role: given or drawn(options, role)
        for role, given in (("target", options.data), ("source", options.source_data))
    }
    shared = {"device": options.device, "seed": options.seed}
    if options.smoke:
        training = source = {**SMOKE, **shared}
    else:
        shared.update(batch_size=options.batch_size, workers=options.workers, validate_epochs=options.validate_epochs,
                      deterministic=not options.fast)
        training, source = {**shared, "epochs": options.epochs}, {**shared, "epochs": options.source_epochs}
    return Plan(options.output, data["target"], data["source"], tuple(options.networks), tuple(options.strategies),
                training, source)


def drawn(options, role):
    """A folder of drawn images below the output; those of an earlier start are used again."""
    from ..data.drawn import write_drawn
    folder = options.output / f"drawn_{role}"
    if not (folder / "ImageSets" / "Main" / "splits.json").exists():
        count = (SMOKE_IMAGES if options.smoke else DRAWN_IMAGES)[role]
        write_drawn(folder, DOMAINS[role], count, options.seed)
    return folder
