"""What a pool gains and costs, in figures. They are printed and judged by nobody: the machine may do other work."""

import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time

from broker import BATCH_END, NODE_BEAT, TILES, Stranger, free_port, kind_of

SCALING = ["--size", "480x270", "--samples", "2"]
BUSY = 0.6  # of the machine's processors, by all paced nodes together, at most
GLASS = ["--size", "1280x720"]
MANY = 8  # samples: passes that are timed together
SETTLED = 3.0  # seconds of a picture before processor time is counted


def rays_of(result):
    return result["rays"]["total"]


def scaling(pool):
    """Nodes that are held to a rate stand for machines of their own (`--pace`): each does all of its work, in the pauses of the
    others. Their rates are so low that all of them together need a part of this machine's processors only."""
    pool.end_nodes()
    command = pool.command(pool.path("scaled.exr"), pool=False, device="embree", picture=SCALING)
    said, core_ms = spent(command)
    rays = rays_of(said)
    pace = BUSY * min(len(pool.cores), 2) * rays / core_ms / 8 / 1e3
    pool.use_reference(pool.path("scaled.exr"))
    times = {}
    for count in (1, 2, 4, 8):
        for number in range(len(pool.nodes), count):
            pool.node(f"paced {number}", options=["--pace", f"{pace:.4f}"], pinned=False)
        times[count] = measured(pool, f"{count} paced nodes", count)
    pool.end_nodes()
    for share in (1, 2, 4):
        pool.node(f"of rate {share}", options=["--pace", f"{share * pace:.4f}"], pinned=False)
    unequal = measured(pool, "three nodes of unequal rates", 3)
    pool.end_nodes()
    print(f"nodes of {pace:.2f} Mrays/s each, {SCALING[1]}, {SCALING[3]} samples, {rays / 1e6:.1f} Mrays:")
    for count, seconds in times.items():
        print(f"  {count} nodes  {seconds:6.2f} s  {times[1] / seconds:.2f} times one, "
              f"{rays / 1e6 / seconds / (count * pace):.3f} of their rates' sum")
    print(f"  rates 1:2:4  {unequal:.2f} s  {rays / 1e6 / unequal / (7 * pace):.3f} of their rates' sum")


def measured(pool, name, nodes):
    """Seconds of a picture; nodes are known to the broker, to the head they are new."""
    out = pool.path("pool.exr")
    result = pool.render(out, nodes=nodes, picture=SCALING)
    pool.same(name, out, result)
    return result.get("ms", {}).get("render", float("nan")) / 1e3


def used(pid):
    """Processor milliseconds of a process' threads so far."""
    total = 0
    for task in os.listdir(f"/proc/{pid}/task"):
        with open(f"/proc/{pid}/task/{task}/schedstat", encoding="utf-8") as file:
            total += int(file.read().split()[0])
    return total / 1e6


def spent(command):
    """(what a command says, its processor milliseconds)."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        said = process.stdout.read()
        _, _, usage = os.wait4(process.pid, 0)
        process.returncode = 0
    return json.loads(said), 1e3 * (usage.ru_utime + usage.ru_stime)


def cost(pool, repetitions=3):
    """A pool of one node on one core against the same core alone, and what the head and the broker spend on it."""
    core = pool.cores[0]
    picture = [*GLASS, "--samples", str(MANY)]
    pool.node("alone")
    pool.render(pool.path("cost.exr"), picture=[*GLASS, "--samples", "1"])
    best = {}
    for _ in range(repetitions):
        local = pool.command(pool.path("cost.exr"), pool=False, device="embree", picture=[*picture, "--set", "embreeThreads=1"])
        row = {"local": spent(["taskset", "-c", str(core), *local])[0]["ms"]["render"] / MANY}
        head = subprocess.Popen(pool.command(pool.path("cost.exr"), picture=picture), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        time.sleep(SETTLED)
        begin, before = time.monotonic(), (used(head.pid), used(pool.broker.process.pid))
        time.sleep(SETTLED)
        seconds, after = time.monotonic() - begin, (used(head.pid), used(pool.broker.process.pid))
        row["pooled"] = json.loads(head.communicate()[0])["ms"]["render"] / MANY
        for what, early, late in zip(("head", "broker"), before, after):
            row[what] = (late - early) / seconds * row["pooled"] / 1e3
        for what, value in row.items():
            best[what] = min(best.get(what, value), value)
    pool.end_nodes()
    print(f"glass, 1280x720, a pass: one core alone {best['local']:.0f} ms, as a pool of one node {best['pooled']:.0f} ms "
          f"({100 * (best['pooled'] / best['local'] - 1):+.1f} %); processor time of the head {best['head']:.1f} ms, of the broker "
          f"{best['broker']:.1f} ms")


def joining(pool):
    """From a node's first word, and from the start of its process, to its first result, with the scene in its folder."""
    out = pool.path("join.exr")
    listener = Stranger(pool.broker)
    listener.subscribe("heliograph.pool.>", 1)
    head = subprocess.Popen(pool.command(out, device="auto", nodes=0, picture=[*GLASS, "--samples", "64"]),
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(2.0)
    begin = time.monotonic()
    pool.node("late")
    heard = None
    for _, data in listener.messages(20.0):
        if kind_of(data) == NODE_BEAT and heard is None:
            heard = time.monotonic()
        if kind_of(data) in (TILES, BATCH_END):
            break
    now = time.monotonic()
    listener.close()
    head.send_signal(signal.SIGKILL)
    head.wait()
    pool.check("a node that joins makes tiles", heard is not None and now - begin < 20.0)
    print(f"a node that joins, scene kept: first result {now - begin:.2f} s after its start, {now - (heard or now):.2f} s after its "
          "first word")
    pool.end_nodes()


def delay(program, load, words, seconds=5):
    """Milliseconds from an input to its picture, of 95 in 100, of a viewer who orbits; None where none came."""
    port = free_port()
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "index.html"), "w", encoding="utf-8") as file:
            file.write("<p>")
        server = subprocess.Popen([program, "serve", "glass", "--listen", f"127.0.0.1:{port}", "--client", folder, *words],
                                  stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        server.stdout.readline()
        time.sleep(6.0)  # the node has the scene, and rates are known
        said = subprocess.run([load, f"ws://127.0.0.1:{port}/ws", "--viewers", "1", "--seconds", str(seconds), "--inputs", "20",
                               "--size", "1280x720", "--script", "orbit", "--json"], capture_output=True, text=True, check=False)
        server.terminate()
        server.wait()
    return json.loads(said.stdout)["motion_to_photon_ms"]["p95"] if said.stdout.startswith("{") else None


def delays(pool, program):
    """A moving view of glass on one core of this machine, and on the same core as a node."""
    load = os.path.join(os.path.dirname(program), "tests", "heliograph-load")
    if not os.access(load, os.X_OK):
        print("not measured: motion to photon (heliograph-load is not built)")
        return
    local = delay(program, load, ["--set", "device=embree", "--set", "embreeThreads=1"])
    pool.node("alone")
    pooled = delay(program, load, [*pool.broker.arguments(), "--set", "device=pool"])
    pool.end_nodes()
    print(f"motion to photon, glass, 1280x720, of 95 in 100: one core {local} ms, as a pool of one node {pooled} ms")


def compression(pool):
    """What zstd and lz4 would make of the results of one pass, message by message as they are, and with the first, second, third
    and fourth bytes of numbers put together, which packs better. Losslessly: anything else would change pictures."""
    if not shutil.which("zstd") or not shutil.which("lz4"):
        print("not measured: compression (zstd and lz4 are not here)")
        return
    line = Stranger(pool.broker)
    line.subscribe("heliograph.pool.head.*", 1)
    pool.node("alone")
    process = pool.start(pool.path("packed.exr"), picture=[*GLASS, "--samples", "1"])
    results = bytearray()
    for _, data in line.messages(60.0):
        if kind_of(data) == TILES:
            results += data
        if process.poll() is not None:
            break
    pool.result(process)
    line.close()
    pool.end_nodes()
    usable = bytes(results[:len(results) // 4 * 4])
    print(f"results of one pass, {GLASS[1]}: {len(results) / 1e6:.2f} MB")
    for name, data in (("as they are", usable), ("bytes apart", b"".join(usable[i::4] for i in range(4)))):
        path = pool.path("results.bin")
        with open(path, "wb") as file:
            file.write(data)
        for tool in (["zstd", "-b1", "-i2", "-B98304"], ["lz4", "-b1", "-i2", "-B98304"]):
            said = subprocess.run([*tool, path], capture_output=True, text=True, check=False)
            figures = re.findall(r"->\s*(\d+).*?([\d.]+) MB/s\s*,\s*([\d.]+) MB/s", (said.stdout + said.stderr).replace("\r", "\n"))
            if figures:
                size, packed, unpacked = figures[-1]
                print(f"  {name}, {tool[0]} 1: {int(size) / 1e6:.2f} MB ({int(size) / len(data):.2f}), {packed} MB/s in, {unpacked} MB/s out")
