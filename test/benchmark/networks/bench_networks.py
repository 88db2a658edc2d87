#!/usr/bin/python3
"""Frames per second of the five networks of the paper: network x library x device x precision.

A sample is one inference of a prepared input, without resizing and decoding (tools/bench detect has the whole path).
The libraries take turns every ten samples, so that all see the same machine. Frames per second are the inverse of the
mean time, with the 95 % confidence interval of that mean. Weights are random: time does not depend on them.

The paper measured on a Core i3-3217U and, as its VPU, on a Neural Compute Stick 2. Its figures are not in this
repository, so that column is empty. OpenVINO dropped the stick (its device MYRIAD) in 2023: those rows cannot be
measured any more; Intel's NPU is its heir.
"""

import argparse
import json
import math
import pathlib
import statistics
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "tools" / "lib")]

from bench_machine import machine  # noqa: E402
from extperfc.training.networks import NETWORKS  # noqa: E402
from extperfc.training.networks.model_folder import input_tensor, read_description  # noqa: E402
from extperfc.training.networks.network_error import NetworkError, RuntimeMissing  # noqa: E402
from extperfc.training.networks.runtimes import RUNTIMES  # noqa: E402

SAMPLES, QUICK_SAMPLES = 300, 6
WARM_UPS, ROUND = 3, 10
CALIBRATION_IMAGES = 20
T_95 = 1.96  # of the normal distribution: with 300 samples Student's is 1.97
PAPER = "paper, Core i3-3217U"
STICK = "no figure: OpenVINO dropped MYRIAD in 2023"
FRAMES, LOW, HIGH, CPU_TIME = "frames", "frames, 95 % low", "frames, 95 % high", "CPU time, median"
CLASSES = ("cone", "cube", "sphere")


def parse(arguments):
    parser = argparse.ArgumentParser(prog="tools/bench networks", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--network", action="append", choices=NETWORKS, help="this one alone (repeatable)")
    parser.add_argument("--model", action="append", type=pathlib.Path, default=[], metavar="FOLDER",
                        help="a model folder too (repeatable)")
    parser.add_argument("--backend", action="append", choices=RUNTIMES, help="this library alone (repeatable)")
    parser.add_argument("--threads", type=int, default=0, help="of the CPU; 0: the library chooses (default)")
    parser.add_argument("--samples", type=int, default=SAMPLES, help=f"per row (default: {SAMPLES})")
    parser.add_argument("--quick", action="store_true", help=f"{QUICK_SAMPLES} samples: for tests, not for figures")
    parser.add_argument("--without-int8", action="store_true", help="no INT8 networks, which need NNCF")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="write the results")
    options = parser.parse_args(arguments)
    if options.samples < 2 or options.threads < 0:
        parser.error("--samples must be at least 2, --threads at least 0")
    options.samples = QUICK_SAMPLES if options.quick else options.samples
    return options


def make_folders(names, scratch, with_int8, note):
    """(title, precision, model folder) of every network, exported with random weights."""
    from extperfc.training.networks.example import example_network
    from extperfc.training.networks.export import export
    for name in names:
        folder = export(example_network(name, CLASSES), scratch / name, CLASSES, source="random weights")
        yield NETWORKS[name].title, "f32", folder
        if with_int8:
            yield from quantized(name, folder, scratch / f"{name}_int8", note)


def quantized(name, folder, output, note):
    """The INT8 folder of a network, or a note why there is none."""
    import numpy as np

    from extperfc.training.data.drawn import draw_image
    from extperfc.training.networks.quantize import quantize
    images = [draw_image(CLASSES, np.random.default_rng(seed))[0][..., ::-1] for seed in range(CALIBRATION_IMAGES)]
    try:
        quantize(folder, images, output)
    except NetworkError as error:
        note(f"no INT8 rows: {error}")
        return
    yield NETWORKS[name].title, "INT8", output


def open_runs(folder, runtimes, threads, note):
    """(library, device, run, input) for every library and device that can run the network of a folder."""
    import numpy as np
    description = read_description(folder)
    image = np.random.default_rng(0).integers(0, 256, (480, 640, 3), np.uint8)
    tensor = input_tensor(image, description)
    for runtime in runtimes:
        try:
            for device in runtime.devices():
                run = runtime(folder / description["file"], description["output"].get("names"), device, threads)
                run.run(tensor)
                yield runtime.name, device, run, tensor
        except RuntimeMissing as missing:
            note(f"no rows of {runtime.name}: {missing}")
        except NetworkError as error:
            note(f"{folder.name}, {runtime.name}: {error}")


def measure(runs, count):
    """Wall and CPU times [s] of `count` inferences of each run, in turns."""
    times = [([], []) for _ in runs]
    for _, _, run, tensor in runs:
        for _ in range(WARM_UPS):
            run.run(tensor)
    for begin in range(0, count, ROUND):
        for (wall, cpu), (_, _, run, tensor) in zip(times, runs):
            for _ in range(min(ROUND, count - begin)):
                at, used = time.perf_counter(), time.process_time()
                run.run(tensor)
                wall.append(time.perf_counter() - at)
                cpu.append(time.process_time() - used)
    return times


def frames_per_second(times):
    """(frames per second, low, high): the inverse of the mean time and of the ends of its 95 % confidence interval."""
    mean = statistics.fmean(times)
    half = T_95 * statistics.stdev(times) / math.sqrt(len(times))
    return 1 / mean, 1 / (mean + half), 1 / (mean - half) if half < mean else math.inf


def row(case, metric, unit, ours, peer_name=None):
    """One comparison, with the keys of every benchmark; a figure that is unknown is null."""
    finite = ours is not None and math.isfinite(ours)
    return {"case": case, "metric": metric, "unit": unit, "ours": ours if finite else None, "peer": None,
            "peer_name": peer_name, "ratio": None, "goal": None, "met": None}


def rows_of(title, precision, folder, options, note):
    """Rows of one network."""
    chosen = [runtime for name, runtime in RUNTIMES.items() if (not options.backend or name in options.backend)
              and (precision != "INT8" or name == "openvino")]  # no other library reads quantize()'s networks
    runs = list(open_runs(folder, chosen, options.threads, note))
    for (library, device, _, _), (wall, cpu) in zip(runs, measure(runs, options.samples)):
        case = f"{title}, {library} {device}, {precision}"
        for metric, value in zip((FRAMES, LOW, HIGH), frames_per_second(wall)):
            yield row(case, metric, "1/s", value, PAPER if device == "CPU" else None)
        yield row(case, CPU_TIME, "ms", statistics.median(cpu) * 1e3)
    if precision == "f32":
        yield row(f"{title}, openvino NCS2 (MYRIAD), f16", FRAMES, "1/s", None, STICK)


def print_table(rows):
    """The paper's table: a line per network, library, device and precision."""
    lines = [("network, library device, precision", "frames/s", "95 % interval", "CPU ms", "paper")]
    of = {(r["case"], r["metric"]): r["ours"] for r in rows}
    for one in (r for r in rows if r["metric"] == FRAMES):
        case = one["case"]
        if one["ours"] is None:
            lines.append((case, "-", "-", "-", one["peer_name"]))
            continue
        high = of[case, HIGH]
        interval = f"{of[case, LOW]:.1f} to {high:.1f}" if high else f"from {of[case, LOW]:.1f}"
        lines.append((case, f"{one['ours']:.1f}", interval, f"{of[case, CPU_TIME]:.1f}", "-"))
    widths = [max(len(line[i]) for line in lines) for i in range(5)]
    for line in lines:
        print(
            "  ".join([line[0].ljust(widths[0]), *(cell.rjust(w) for cell, w in zip(line[1:4], widths[1:4])), line[4]])
        )


def run(options):
    """Measures and prints; 0, or 1 when no network could be measured."""
    notes, rows = [], []

    def note(text):
        if text not in notes:
            notes.append(text)
            print(text, file=sys.stderr, flush=True)
    with tempfile.TemporaryDirectory() as scratch:
        names = options.network or ([] if options.model else list(NETWORKS))
        folders = list(make_folders(names, pathlib.Path(scratch), not options.without_int8, note))
        folders += [(str(folder.name), "model folder", folder) for folder in options.model]
        for title, precision, folder in folders:
            print(f"{title} {precision}", file=sys.stderr, flush=True)
            rows += rows_of(title, precision, folder, options, note)
    print(
        f"{machine()}, {options.samples} samples per row{', --quick: no figures to report' if options.quick else ''}\n"
    )
    print_table(rows)
    print(f"\nThe paper's own figures ({PAPER}, and its NCS2) are not in this repository: their column is empty.")
    if options.json:
        content = {"name": "networks", "machine": machine(), "rows": rows}
        options.json.write_text(json.dumps(content, indent=1) + "\n")
    return 0 if any(r["ours"] is not None for r in rows) else 1


def main(arguments=None):
    try:
        return run(parse(arguments))
    except (NetworkError, OSError) as error:
        print(f"bench_networks: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
