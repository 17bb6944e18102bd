#!/usr/bin/env python3
"""A pool of real processes: a broker, nodes and heads. pool.py PROGRAM [SCENE]: pictures that nodes make are those of one
machine, byte for byte, whatever happens to nodes, line and broker meanwhile. The last line is `N passed, N failed`; figures
are printed, and judged by nobody: the machine may do other work."""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from broker import BATCH_END, Broker, Stranger, kind_of, message, peer_of  # noqa: E402

PROGRAM = os.path.abspath(sys.argv[1])
SCENE = sys.argv[2] if len(sys.argv) > 2 else "glass"
PICTURE = ["--size", "480x270", "--samples", "6"]
LONGEST = 60  # seconds that one render may take


class Pool:
    def __init__(self, folder):
        self.folder = folder
        self.passed = self.failed = 0
        self.nodes = {}
        self.broker = Broker(folder)
        self.cores = sorted(os.sched_getaffinity(0))
        self.local = self.path("local.exr")
        self.local_ms = self.render(self.local, pool=False, device="embree")["ms"]["render"]

    def path(self, name):
        return os.path.join(self.folder, name)

    def check(self, name, holds, why=""):
        if holds:
            self.passed += 1
        else:
            self.failed += 1
            print(f"FAILED {name}: {why}")

    def node(self, name, program=PROGRAM, broker=None):
        """A node on a core of its own, if there are several."""
        core = self.cores[len(self.nodes) % len(self.cores)]
        log = open(self.path(name + ".log"), "wb")
        self.nodes[name] = subprocess.Popen(
            [program, "node", *(broker or self.broker).arguments(), "--name", name, "--scene-cache", self.path("cache")],
            stdout=log, stderr=log, preexec_fn=lambda: os.sched_setaffinity(0, {core}))
        return self.nodes[name]

    def end_node(self, name, kind=signal.SIGTERM):
        process = self.nodes.pop(name)
        process.send_signal(signal.SIGCONT)
        process.send_signal(kind)
        process.wait()

    def log(self, name):
        with open(self.path(name + ".log"), encoding="utf-8") as file:
            return file.read()

    def command(self, out, pool=True, device="pool", nodes=1, picture=None):
        command = [PROGRAM, "render", SCENE, *(picture or PICTURE), "--device", device, "--out", out, "--json"]
        return command + ([*self.broker.arguments(), "--pool-nodes", str(nodes)] if pool else [])

    def start(self, out, **options):
        return subprocess.Popen(self.command(out, **options), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def result(self, process):
        said, log = process.communicate(timeout=LONGEST)
        return (json.loads(said) if process.returncode == 0 else {"failed": log}), log

    def render(self, out, **options):
        return self.result(self.start(out, **options))[0]

    def same(self, name, out, result):
        if "failed" in result:
            self.check(name, False, result["failed"][-400:])
            return
        with open(out, "rb") as made, open(self.local, "rb") as local:
            self.check(name, made.read() == local.read(), "the picture differs")

    def disturbed(self, name, disturb, nodes):
        """A picture during which `disturb` happens, once nodes have answered some batches of it."""
        out = self.path("disturbed.exr")
        listener = Stranger(self.broker)
        listener.subscribe("heliograph.pool.head.*", 1)
        before = time.monotonic()
        process = self.start(out, nodes=nodes)
        ends = (data for _, data in listener.messages(LONGEST) if kind_of(data) == BATCH_END)
        for _ in range(3):
            next(ends, None)
        listener.close()
        disturb()
        result, log = self.result(process)
        self.same(name, out, result)
        return result, time.monotonic() - before, log


def pictures(pool):
    out = pool.path("pool.exr")
    pool.node("one")
    begin = time.monotonic()
    one = pool.render(out)
    pool.same("one node", out, one)
    first = time.monotonic() - begin
    pool.node("two")
    two = pool.render(out, nodes=2)
    pool.same("two nodes", out, two)
    pool.check("both nodes made tiles", sum(name.startswith("node:") for name in two["tiles"]) == 2, two["tiles"])
    again = pool.render(out, nodes=2)
    all_ = pool.render(out, device="auto", nodes=2)
    pool.same("nodes and the head's own device", out, all_)
    print(f"local {pool.local_ms:.0f} ms on {len(pool.cores)} cores; one node on one core {one['ms']['render']:.0f} ms, two "
          f"{again['ms']['render']:.0f} ms ({one['ms']['render'] / again['ms']['render']:.2f} times); first picture with the "
          f"scene's transfer {first:.2f} s; build with the scene kept {again['ms']['build']:.0f} ms")


def dying_nodes(pool):
    result, seconds, _ = pool.disturbed("kill -9 of a node", lambda: pool.end_node("two", signal.SIGKILL), 2)
    print(f"kill -9 of one of two: the picture took {seconds:.2f} s in all, tiles {result.get('tiles')}")
    pool.node("two")
    stopped = pool.nodes["two"]
    result, seconds, _ = pool.disturbed("SIGSTOP of a node", lambda: stopped.send_signal(signal.SIGSTOP), 2)
    print(f"SIGSTOP of one of two: {seconds:.2f} s in all, tiles {result.get('tiles')}")
    stopped.send_signal(signal.SIGCONT)
    out = pool.path("pool.exr")
    pool.same("after SIGCONT it is back", out, pool.render(out, nodes=2))


def dying_broker(pool):
    result, seconds, log = pool.disturbed("the broker dies", lambda: pool.broker.stop(signal.SIGKILL), 2)
    pool.check("the head says that the line is lost", "is lost" in log, log[-300:])
    print(f"the broker dies: {seconds:.2f} s in all, tiles {result.get('tiles')}")
    pool.broker.start()
    out = pool.path("pool.exr")
    pool.same("the broker is back, so are the nodes", out, pool.render(out, nodes=2))


def strangers(pool):
    stranger = Stranger(pool.broker)
    stranger.subscribe("heliograph.pool.>", 1)
    random.seed(18)
    made = pool.start(pool.path("garbage.exr"), nodes=2)
    subjects = {"heliograph.pool.nodes", "heliograph.pool.heads"}
    for subject, data in stranger.messages(2.0):
        if subject.endswith(".nodes"):
            subjects.add("heliograph.pool.node." + peer_of(data))
        if subject.endswith(".heads"):
            subjects.update(f"heliograph.pool.{kind}.{peer_of(data)}" for kind in ("head", "scene"))
    pool.check("a head and two nodes are heard", len(subjects) == 6, subjects)
    sent = 0
    while sent < 100000:
        batch = []
        for _ in range(500):
            noise = random.randbytes(random.randrange(120))
            batch.append((random.choice(sorted(subjects)), noise if random.random() < 0.3 else message(random.randrange(14), noise)))
        stranger.publish_all(batch)
        sent += len(batch)
    result, _ = pool.result(made)
    pool.same("10^5 messages of garbage", pool.path("garbage.exr"), result)
    out = pool.path("pool.exr")
    pool.same("the pool after them", out, pool.render(out, nodes=2))
    pool.check("the nodes live", all(node.poll() is None for node in pool.nodes.values()))
    stranger.close()


def refusals(pool):
    wrong = pool.path("wrong.secret")
    with open(wrong, "w", encoding="utf-8") as file:
        file.write("pool:another long secret\n")
    for command in (["node"], ["render", SCENE, *PICTURE, "--out", pool.path("x.png")]):
        said = subprocess.run([PROGRAM, *command, "--pool", pool.broker.url, "--pool-secret", wrong], capture_output=True,
                              text=True, timeout=LONGEST, check=False)
        pool.check(f"{command[0]} with wrong credentials", said.returncode == 2 and "refuses who comes" in said.stderr, said.stderr)
    said = subprocess.run([PROGRAM, "node", "--pool", "nats://192.0.2.1:4222"], capture_output=True, text=True, check=False,
                          timeout=LONGEST)
    pool.check("another machine without a secret", said.returncode == 2 and "--pool-insecure" in said.stderr, said.stderr)
    other = pool.path("other-build")
    shutil.copy(PROGRAM, other)
    with open(other, "ab") as file:
        file.write(b"another build")
    pool.node("stranger", program=other)
    out = pool.path("pool.exr")
    result = pool.render(out, nodes=2)
    pool.same("beside a node of another build", out, result)
    pool.check("a node of another build makes nothing", len([n for n in result["tiles"] if n.startswith("node")]) == 2, result)
    pool.check("a node of another build is told why", "is of another build" in pool.log("stranger"), pool.log("stranger"))
    pool.end_node("stranger")


def main():
    folder = tempfile.mkdtemp(prefix="heliograph-pool-")
    pool = Pool(folder)
    try:
        for part in (pictures, dying_nodes, dying_broker, strangers, refusals):
            begin = time.monotonic()
            part(pool)
            print(f"  {part.__name__}: {time.monotonic() - begin:.1f} s")
    finally:
        for name in list(pool.nodes):
            pool.end_node(name)
        pool.broker.stop()
        shutil.rmtree(folder)
    print(f"{pool.passed} passed, {pool.failed} failed")
    sys.exit(pool.failed > 0 or pool.passed == 0)


main()
