"""lists the networks that can be trained, with their parameter counts"""


def add_arguments(parser):
    parser.add_argument(
        "--count", type=int, metavar="CLASSES", help="build each for so many classes and count its parameters"
    )


def run(options):
    from ..networks import NETWORKS
    print(f"{'name':<24} {'input':<10} {'parameters':>11} {'in the paper':>13}   (3 classes)")
    for name, spec in NETWORKS.items():
        size = f"{spec.input_size[0]} x {spec.input_size[1]}"
        print(f"{name:<24} {size:<10} {spec.parameters:>11,} {spec.paper_parameters:>13,}")
    if options.count is not None:
        show_counts(options.count)
    return 0


def show_counts(classes):
    """Parameters of every network for so many classes."""
    from ..networks import NETWORKS, build
    from ..networks.network_error import NetworkError
    if classes < 1:
        raise NetworkError(f"--count must be at least 1, not {classes}")
    print(f"\nfor {classes} classes:")
    for name in NETWORKS:
        network = build(name, [f"class{i}" for i in range(classes)])
        print(f"{name:<24} {sum(parameter.numel() for parameter in network.parameters()):>11,}")
