#!/usr/bin/python3
"""Draws latency and CPU time by message size from the JSON that `tools/bench translate --json` writes."""

import argparse
import json
import sys

try:
    import matplotlib
except ImportError:
    sys.exit("plot_translator: needs matplotlib; install python3-matplotlib")
matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the back end)

SIZES = ("200 B", "2 kB", "100 kB", "1 MB", "6 MB")
STYLES = {"direct": ("0.6", "o"), "relay": ("tab:red", "s"), "pass": ("tab:blue", "^"), "convert": ("tab:green", "v")}


def values(rows, metric):
    """{route: [value by size]} of a metric [us]; peers' values stand in the rows of `pass`."""
    found = {}
    for row in rows:
        size, _, route = row["case"].partition(", ")
        if row["metric"] != metric or size not in SIZES or route not in ("pass", "convert"):
            continue
        found.setdefault(route, {})[size] = row["ours"]
        if row["peer"] is not None:
            found.setdefault(row["peer_name"], {})[size] = row["peer"]
    return {route: [of_size.get(size) for size in SIZES] for route, of_size in found.items()}


def draw(axis, table, title):
    for route, (color, marker) in STYLES.items():
        if route in table:
            axis.plot(SIZES, table[route], color=color, marker=marker, label=route)
    axis.set_yscale("log")
    axis.set_title(title)
    axis.grid(alpha=0.3, which="both")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("json", help="written by tools/bench translate --json")
    parser.add_argument("png", help="image to write")
    arguments = parser.parse_args()
    with open(arguments.json, encoding="utf-8") as file:
        rows = json.load(file)["rows"]
    tables = [(title, values(rows, metric)) for title, metric in
              (("latency, median [us]", "latency p50"), ("latency, 99th percentile [us]", "latency p99"),
               ("CPU per message [us]", "CPU per message"))]
    if not tables[0][1]:
        sys.exit(f"plot_translator: {arguments.json} holds no latencies; was it written by tools/bench translate --json?")
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.8))
    for axis, (title, table) in zip(axes, tables):
        draw(axis, table, title)
    axes[0].legend(fontsize="small")
    figure.tight_layout()
    figure.savefig(arguments.png, dpi=110)


if __name__ == "__main__":
    main()
