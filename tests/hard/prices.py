#!/usr/bin/env python3
"""What the remedies of docs/reference/stability.md cost on the processor. Each patch of remedies/ takes one of them out of the
sources: what a plain tracer does in its place. For each a copy of the tree is built in out/remedies/tree, and its program kept
in out/remedies/NAME. Then frames of it and of the program as it is are rendered in turns, by processes that are started anew
STARTS times; a price is what the remedy adds to the time of the program without it. The last line is `N passed, N failed`: the
programs that gave frames, and that all remedies together cost at most GOAL percent of an interactive frame.

    tests/hard/prices.py                  builds what has changed, measures, prints the table
    tests/hard/prices.py --measure-only   with the programs that are there
    tests/hard/prices.py --build-only
    tests/hard/prices.py --check          whether each patch still applies, alone and all one after the other

Two rows take nothing out. `none` is the program beside a copy of itself: the machine's unrest. `layout` is the program with
its code moved by no-operations: what a price may owe to where code comes to lie."""

import argparse
import hashlib
import json
import os
import random
import shutil
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../.."))
PATCHES = os.path.join(ROOT, "tests/hard/remedies")
OUT = os.path.join(ROOT, "out/remedies")
SOURCES = ("server/", "shaders/", "cmake/", "CMakeLists.txt")  # of the program
GOAL = 5.0  # percent of an interactive frame, all together
AS_IT_IS = "as_it_is"
ALL = "all"
NOTHING = ["none", "layout"]  # rows that take nothing out
ROBUST = "robust"             # a setting, off by default
WARM_UP = 1                   # pairs of each start that are not counted

INTERACTIVE = ("640x360", 1, [])
PATH = ("320x180", 2, ["integrator=path"])
COLUMNS = {
    "courtyard": ("courtyard", *INTERACTIVE),
    "glass": ("glass", *INTERACTIVE),
    "courtyard, path": ("courtyard", *PATH),
    "glass, path": ("glass", *PATH),
}


def patch_file(name):
    return os.path.join(PATCHES, name + ".patch")


def patch_names():
    """What takes a remedy out. Last what touches a header of many, so that little is compiled twice."""
    names = [file[:-6] for file in os.listdir(PATCHES) if file.endswith(".patch")]
    wide = {name: any("server/film/" in path for path in touched([name])) for name in names}
    return sorted((name for name in names if name not in NOTHING), key=lambda name: (wide[name], name))


def told(name):
    """The lines before a patch that say what it is about."""
    with open(patch_file(name), encoding="utf-8") as file:
        head = file.read().split("--- a/", 1)[0]
    return dict(line.split(": ", 1) for line in head.splitlines() if ": " in line)


def touched(names):
    paths = []
    for name in names:
        with open(patch_file(name), encoding="utf-8") as file:
            paths += [line[6:].strip() for line in file if line.startswith("+++ b/")]
    return sorted(set(paths))


def patched(names, patches=PATCHES):
    """{path: bytes} of the files that these patches touch, after all of them. Raises where one does not apply."""
    with tempfile.TemporaryDirectory() as folder:
        for path in touched(names):
            os.makedirs(os.path.dirname(os.path.join(folder, path)), exist_ok=True)
            shutil.copyfile(os.path.join(ROOT, path), os.path.join(folder, path))
        for name in names:
            done = subprocess.run(["git", "apply", os.path.join(patches, name + ".patch")], cwd=folder, capture_output=True, text=True,
                                  env={**os.environ, "GIT_CEILING_DIRECTORIES": os.path.dirname(folder)}, check=False)
            if done.returncode != 0:
                raise RuntimeError(f"{name}.patch does not apply after {' '.join(names[:names.index(name)]) or 'nothing'}: {done.stderr.strip()}")
        result = {}
        for path in touched(names):
            with open(os.path.join(folder, path), "rb") as file:
                result[path] = file.read()
        return result


def check():
    """Each alone, and all; and that a patch that has rotted is found."""
    passed = failed = 0

    def count(holds, what):
        nonlocal passed, failed
        passed, failed = passed + holds, failed + (not holds)
        if not holds:
            print("FAILED " + what)

    names = patch_names()
    for chosen in [[name] for name in names + ["layout"]] + [names]:
        try:
            patched(chosen)
            count(True, "")
        except (RuntimeError, OSError) as error:
            count(False, str(error))
    for name in names:
        count(set(told(name)) == {"Remedy", "Plain", "Held by"}, f"{name}.patch: lacks Remedy, Plain or Held by before the patch")
    with tempfile.TemporaryDirectory() as folder:
        with open(patch_file(names[0]), encoding="utf-8") as file, open(os.path.join(folder, names[0] + ".patch"), "w", encoding="utf-8") as rotten:
            rotten.write(file.read().replace("\n-", "\n-rotten "))
        try:
            patched([names[0]], folder)
            count(False, "a patch that does not apply was not found")
        except RuntimeError:
            count(True, "")
    print(f"{passed} passed, {failed} failed")
    return failed == 0


# ---- building ----

def listed():
    done = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    return [path for path in done.stdout.decode().split("\0") if path and os.path.isfile(os.path.join(ROOT, path))]


def tree_with(names):
    """{path: bytes} of the whole tree, these patches applied."""
    changed = patched(names) if names else {}
    tree = {}
    for path in listed():
        if path in changed:
            tree[path] = changed[path]
            continue
        with open(os.path.join(ROOT, path), "rb") as file:
            tree[path] = file.read()
    return tree


def write_tree(tree, folder):
    """Only what differs, so that little is built."""
    for path, content in tree.items():
        target = os.path.join(folder, path)
        try:
            with open(target, "rb") as file:
                if file.read() == content:
                    continue
        except FileNotFoundError:
            os.makedirs(os.path.dirname(target), exist_ok=True)
        with open(target, "wb") as file:
            file.write(content)
        shutil.copymode(os.path.join(ROOT, path), target)
    kept = set(tree)
    for at, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if name not in ("build", "out", "node_modules")]
        for name in files:
            path = os.path.join(at, name)
            if os.path.relpath(path, folder) not in kept:
                os.remove(path)


def own_isa():
    """The instruction set that the program takes here, as server/kernel/instruction_set.h has it."""
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        flags = set(next((line for line in file if line.startswith("flags")), "").split())
    v3 = {"avx2", "bmi1", "bmi2", "fma"} <= flags
    return "v4" if v3 and {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"} <= flags else "v3" if v3 else "v2"


def program_of(name):
    return os.path.join(OUT, name, "heliograph")


def build(name, patches):
    """Builds the tree with these patches and keeps its program, unless it is there. False where that failed."""
    tree = tree_with(patches)
    digest = hashlib.sha256(own_isa().encode())
    for path in sorted(path for path in tree if path.startswith(SOURCES)):
        digest.update(path.encode() + b"\0" + hashlib.sha256(tree[path]).digest())
    stamp = os.path.join(OUT, name, "stamp")
    if os.path.exists(program_of(name)) and os.path.exists(stamp):
        with open(stamp, encoding="ascii") as file:
            if file.read() == digest.hexdigest():
                return True
    print(f"building {name}", flush=True)
    folder = os.path.join(OUT, "tree")
    os.makedirs(os.path.join(OUT, name), exist_ok=True)
    write_tree(tree, folder)
    log = os.path.join(OUT, name, "build.log")
    steps = (". tools/setup.sh && configure release -DHELIOGRAPH_TESTS=OFF -DHELIOGRAPH_ONE_ISA=" + own_isa() +
             " && ninja -C build/release heliograph")
    with open(log, "w", encoding="utf-8") as file:
        done = subprocess.run(["bash", "-c", steps], cwd=folder, stdout=file, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, check=False)
    if done.returncode != 0:
        print(f"FAILED {name} does not build: see {log}")
        return False
    shutil.copy2(os.path.join(folder, "build/release/heliograph"), program_of(name))
    with open(stamp, "w", encoding="ascii") as file:
        file.write(digest.hexdigest())
    return True


def build_all(chosen):
    """The names whose program is there."""
    built = []
    if not build(AS_IT_IS, []):
        return built
    wanted = [("layout", ["layout"])] + [(name, [name]) for name in patch_names()] + [(ALL, patch_names())]
    for name, patches in wanted:
        if (not chosen or name in chosen) and build(name, patches):
            built.append(name)
    return built


# ---- measuring ----

class Renderer:
    """A program that renders a frame when it is told to (server/lab/bench_partner.h)."""

    def __init__(self, program, column, settings=()):
        scene, size, samples, more = COLUMNS[column]
        command = [program, "bench", "effects", scene, "--answer", "--device", "embree", "--size", size, "--samples", str(samples)]
        for setting in [*more, *settings]:
            command += ["--set", setting]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                        env={**os.environ, "HELIOGRAPH_CACHE": ""})
        self.greeting = self.line()

    def line(self):
        text = self.process.stdout.readline()
        if not text:
            raise RuntimeError(f"{self.process.args[0]} ended early, exit code {self.process.wait()}")
        return json.loads(text)

    def frame(self):
        """Processor milliseconds, and rays."""
        self.process.stdin.write(b"frame\n")
        self.process.stdin.flush()
        answer = self.line()
        return answer["core_ms"], sum(answer["rays"])

    def close(self):
        self.process.stdin.close()
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def compare(own, other, pairs, turn):
    """(median ratio of the time of `own` over that of `other`, milliseconds of both, their rays), frame by frame in turns."""
    ratios, times, rays = [], [], (0, 0)
    for i in range(WARM_UP + pairs):
        first_own = (i + turn) % 2 == 0
        first = (own if first_own else other).frame()
        second = (other if first_own else own).frame()
        mine, its = (first, second) if first_own else (second, first)
        rays = (mine[1], its[1])
        if i >= WARM_UP:
            ratios.append(mine[0] / its[0])
            times.append((mine[0], its[0]))
    return statistics.median(ratios), tuple(statistics.median(t[k] for t in times) for k in (0, 1)), rays


def measure_start(column, names, pairs, turn, results):
    """One start of all programs: each beside the program as it is."""
    base = Renderer(program_of(AS_IT_IS), column)
    order = list(names)
    random.Random(turn).shuffle(order)
    for name in order:
        program = program_of(AS_IT_IS if name in ("none", ROBUST) else name)
        row = results.setdefault(name, {}).setdefault(column, {"ratios": [], "ms": [], "rays": []})
        try:
            other = Renderer(program, column, ["robust=on"] if name == ROBUST else [])
            ratio, times, rays = compare(base, other, pairs, turn)
            other.close()
        except (RuntimeError, ValueError) as error:
            row["failed"] = str(error)
            continue
        if name == ROBUST:  # there the remedy is the other's
            ratio, times, rays = 1.0 / ratio, times[::-1], rays[::-1]
        row["ratios"].append(ratio)
        row["ms"].append(times)
        row["rays"].append(rays)
    base.close()
    return base.greeting["device"]


def measure(names, columns, starts, pairs):
    results, device = {}, ""
    for turn in range(starts):
        for column in columns:
            device = measure_start(column, names, pairs, turn, results)
            if sys.stderr.isatty():
                print(f"\r\033[Kstart {turn + 1} of {starts}, {column}", end="", file=sys.stderr, flush=True)
    if sys.stderr.isatty():
        print("\r\033[K", end="", file=sys.stderr)
    return summary(results), device


def summary(results):
    """Prices in percent: median and quartiles over the starts."""
    rows = {}
    for name, by_column in results.items():
        for column, row in by_column.items():
            if not row["ratios"]:
                rows.setdefault(name, {})[column] = {"failed": row.get("failed", "no frames")}
                continue
            prices = sorted(100.0 * (ratio - 1.0) for ratio in row["ratios"])
            low, middle, high = statistics.quantiles(prices, n=4, method="inclusive") if len(prices) > 1 else prices * 3
            with_rays, without_rays = row["rays"][-1]
            rows.setdefault(name, {})[column] = {
                "price": middle, "low": low, "high": high, "starts": len(prices),
                "ms": statistics.median(ms[0] for ms in row["ms"]), "ms_without": statistics.median(ms[1] for ms in row["ms"]),
                "rays": with_rays, "rays_without": without_rays}
    return rows


# ---- telling ----

def in_order(rows, columns):
    """The dearest first, by the mean over the columns; then what is no remedy by itself."""
    apart = [ROBUST, ALL, *NOTHING]

    def cost(name):
        return statistics.fmean(rows[name][c]["price"] if "price" in rows[name][c] else 0.0 for c in columns)

    return sorted((n for n in rows if n not in apart), key=cost, reverse=True) + [n for n in apart if n in rows]


def cell(row):
    if "failed" in row:
        return "failed"
    more = row["rays_without"] / max(row["rays"], 1) - 1.0
    return f"{row['price']:+.1f} ({row['low']:+.1f} to {row['high']:+.1f})" + ("*" if abs(more) > 0.001 else "")


def table(rows, columns):
    names = in_order(rows, columns)
    lines = ["| without | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    for name in names:
        lines.append(f"| {name} | " + " | ".join(cell(rows[name][c]) for c in columns) + " |")
    return "\n".join(lines)


def meaning(names):
    lines = []
    for name in names:
        if os.path.exists(patch_file(name)) and name not in NOTHING:
            head = told(name)
            lines += [f"{name}: {head['Remedy']}", f"    a plain tracer: {head['Plain']}", f"    held by {head['Held by']}"]
    return "\n".join(lines)


def judge(rows, columns):
    passed = failed = 0
    for name, by_column in rows.items():
        for column, row in by_column.items():
            passed, failed = passed + ("failed" not in row), failed + ("failed" in row)
            if "failed" in row:
                print(f"FAILED {name} in {column}: {row['failed']}")
    for column in columns:
        row = rows.get(ALL, {}).get(column, {})
        if COLUMNS[column][3] or "price" not in row:  # the goal is of interactive frames
            continue
        holds = row["price"] <= GOAL
        passed, failed = passed + holds, failed + (not holds)
        print(f"{'holds ' if holds else 'FAILED'} all together in {column}: {row['price']:.1f} %, goal {GOAL:.0f} %")
    print(f"{passed} passed, {failed} failed")
    return failed == 0 and passed > 0


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    mode = parser.add_mutually_exclusive_group()
    for name in ("check", "build-only", "measure-only"):
        mode.add_argument("--" + name, action="store_true")
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="these rows alone")
    parser.add_argument("--columns", nargs="+", default=list(COLUMNS), choices=list(COLUMNS), metavar="COLUMN")
    parser.add_argument("--starts", type=int, default=9, metavar="N", help="of each program (9)")
    parser.add_argument("--pairs", type=int, default=5, metavar="N", help="of frames a start, of which the median counts (5)")
    parser.add_argument("--json", metavar="FILE", help="writes all figures there")
    return parser.parse_args()


def main():
    options = arguments()
    if options.check:
        return check()
    names = [*patch_names(), ALL, "layout"]
    there = [n for n in names if os.path.exists(program_of(n))] if options.measure_only else build_all(options.only)
    missing = [n for n in names if n not in there and (not options.only or n in options.only)]
    for name in missing:
        print(f"FAILED {name} has no program")
    if options.build_only:
        print(f"{len(there)} passed, {len(missing)} failed")
        return not missing
    rows = [n for n in [*there, "none", ROBUST] if not options.only or n in options.only]
    prices, device = measure(rows, options.columns, options.starts, options.pairs)
    print(meaning(in_order(prices, options.columns)))
    print(f"\n{device}; percent of the frame without the remedy, median (quartiles) of {options.starts} starts\n")
    print(table(prices, options.columns))
    print("\n* the plain program traces other rays\n")
    if options.json:
        with open(options.json, "w", encoding="utf-8") as file:
            json.dump({"device": device, "goal": GOAL, "starts": options.starts, "pairs": options.pairs,
                       "remedies": {n: told(n) for n in patch_names()}, "rows": prices}, file, indent=1)
    return judge(prices, options.columns) and not missing


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
