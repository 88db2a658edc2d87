"""Runs a demonstration again and again, each seed in a process of its own."""

import subprocess
import sys

from demo_options import REPO


def each_seed(script, options, arguments, header, files):
    """Runs tools/lib/SCRIPT with --one, its --seed and --out, and `arguments`; the exit code. header: of the table that the runs
    print; files: what each leaves in its folder."""
    print(header, flush=True)
    good, ended = 0, 0
    for seed in range(options.seed, options.seed + options.runs):
        command = [sys.executable, str(REPO / "tools/lib/run_tool.py"), script, "--one", "--seed", str(seed),
                   "--out", str(options.out / f"seed_{seed}"), "--speed", str(options.speed), *arguments,
                   *(["--no-rviz"] if options.no_rviz else [])]
        with subprocess.Popen(command) as run:
            try:
                code = run.wait()
            except KeyboardInterrupt:  # of which the run heard, too
                run.wait()
                break
        ended += 1
        good += code == 0
    print(f"{good} of {ended} runs succeeded{'' if ended == options.runs else f', {options.runs - ended} were not run'}; "
          f"{options.out} has each one's {files}")
    return 0 if good == options.runs else 1
