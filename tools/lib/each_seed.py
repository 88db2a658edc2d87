"""Runs a demonstration again and again, each seed in a process of its own."""

import subprocess
import sys

from demo_options import REPO


def each_seed(script, options, arguments, header, files):
    """Runs tools/lib/SCRIPT with --one, its --seed and --out, and `arguments`; the exit code. header: of the table that the runs
    print; files: what each leaves in its folder."""
    print(header, flush=True)
    good = 0
    for seed in range(options.seed, options.seed + options.runs):
        command = [sys.executable, str(REPO / "tools/lib/run_tool.py"), script, "--one", "--seed", str(seed),
                   "--out", str(options.out / f"seed_{seed}"), "--speed", str(options.speed), *arguments,
                   *(["--no-rviz"] if options.no_rviz else [])]
        good += subprocess.run(command, check=False).returncode == 0
    print(f"{good} of {options.runs} runs succeeded; {options.out} has each one's {files}")
    return 0 if good == options.runs else 1
