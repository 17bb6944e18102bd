#!/usr/bin/env python3
"""How fast and how light programs start, side by side.

start_bench.py PROGRAM... [--rounds N]: runs each of some commands with each program in turn, N rounds (15), and prints
medians: seconds from start to end, seconds of processor time, and the largest memory in MB. With two programs it prints
the differences too. Nothing that compiled programs for GPUs left behind is used.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time

COMMANDS = {
    "--version": ["--version"],
    "inspect glass": ["inspect", "glass", "--json"],
    "first courtyard frame": ["render", "courtyard", "--device", "embree", "--size", "640x360", "--samples", "1", "--out", "FOLDER/a.png"],
}


def run(program, arguments):
    """(wall seconds, processor seconds, peak MB) of one run."""
    begin = time.monotonic()
    process = subprocess.Popen([program, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    said = process.stderr.read()
    _, status, used = os.wait4(process.pid, 0)
    wall = time.monotonic() - begin
    if status:
        sys.exit(f"{program} {' '.join(arguments)}: {said.decode(errors='replace')}")
    return wall, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024 / 1e6


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs="+", metavar="PROGRAM")
    parser.add_argument("--rounds", type=int, default=15)
    options = parser.parse_args()
    os.environ["HELIOGRAPH_CACHE"] = ""
    with tempfile.TemporaryDirectory() as folder:
        for name, arguments in COMMANDS.items():
            arguments = [argument.replace("FOLDER", folder) for argument in arguments]
            runs = {program: [] for program in options.programs}
            for _ in range(options.rounds):
                for program in options.programs:
                    runs[program].append(run(program, arguments))
            print(name)
            medians = []
            for program, results in runs.items():
                medians.append([statistics.median(column) for column in zip(*results)])
                print("  {:6.3f} s  {:6.3f} s of processor  {:6.1f} MB  {}".format(*medians[-1], program))
            if len(medians) == 2:
                print("  {:+6.3f} s  {:+6.3f} s of processor  {:+6.1f} MB".format(*(b - a for a, b in zip(*medians))))


if __name__ == "__main__":
    main()
