"""What a benchmark ran on."""

import os
import pathlib


def machine():
    """Processor and number of hardware threads."""
    lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
    models = [line.split(": ", 1)[1] for line in lines if line.startswith("model name")]
    return f"{models[0] if models else 'unknown processor'}, {os.cpu_count()} threads"
