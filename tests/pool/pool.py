#!/usr/bin/env python3
"""A pool of real processes: a broker, nodes and heads. pool.py PROGRAM [SCENE [PART...]]: pictures that nodes make are those of one
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
import threading
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import figures  # noqa: E402
import timeline  # noqa: E402
from broker import BATCH_END, Authority, Broker, Stranger, kind_of, message, own_address, peer_of, write  # noqa: E402
from line import Line  # noqa: E402

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
        self.reference = self.local = self.path("local.exr")
        self.local_ms = self.render(self.local, pool=False, device="embree")["ms"]["render"]

    def path(self, name):
        return os.path.join(self.folder, name)

    def check(self, name, holds, why=""):
        if holds:
            self.passed += 1
        else:
            self.failed += 1
            print(f"FAILED {name}: {why}")

    def node(self, name, program=PROGRAM, broker=None, options=(), pinned=True, cache="cache"):
        """A node on a core of its own, if there are several. `broker`: what says how to reach it."""
        cores = {self.cores[len(self.nodes) % len(self.cores)]} if pinned else set(self.cores)
        log = open(self.path(name + ".log"), "wb")
        self.nodes[name] = subprocess.Popen(
            [program, "node", *(broker or self.broker).arguments(), "--name", name, "--scene-cache", self.path(cache), *options],
            stdout=log, stderr=log, preexec_fn=lambda: os.sched_setaffinity(0, cores))
        return self.nodes[name]

    def end_nodes(self):
        for name in list(self.nodes):
            self.end_node(name)

    def end_node(self, name, kind=signal.SIGTERM):
        process = self.nodes.pop(name)
        process.send_signal(signal.SIGCONT)
        process.send_signal(kind)
        process.wait()

    def log(self, name):
        with open(self.path(name + ".log"), encoding="utf-8") as file:
            return file.read()

    def command(self, out, pool=True, device="pool", nodes=1, picture=None, broker=None):
        command = [PROGRAM, "render", SCENE, *(picture or PICTURE), "--device", device, "--out", out, "--json"]
        return command + ([*(broker or self.broker).arguments(), "--pool-nodes", str(nodes)] if pool else [])

    def start(self, out, **options):
        return subprocess.Popen(self.command(out, **options), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def result(self, process):
        said, log = process.communicate(timeout=LONGEST)
        return (json.loads(said) if process.returncode == 0 else {"failed": log}), log

    def render(self, out, **options):
        return self.result(self.start(out, **options))[0]

    def remote(self, name, broker, arguments):
        """A picture of a node and a head that reach that broker so."""
        class Way:
            def arguments(self):
                return arguments

        self.node(name, broker=Way())
        out = self.path("remote.exr")
        self.same(name, out, self.render(out, broker=Way()))
        self.end_node(name)

    def same(self, name, out, result):
        if "failed" in result:
            self.check(name, False, result["failed"][-400:])
            return
        with open(out, "rb") as made, open(self.reference, "rb") as local:
            self.check(name, made.read() == local.read(), "the picture differs")

    def use_reference(self, path):
        """Pictures are compared with this one from now on."""
        self.reference = path

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


def bad_lines(pool):
    """A third node, behind a line that is cut for five seconds, or carries 10 Mbit/s."""
    line = Line(pool.broker)
    pool.node("far", broker=line)
    out = pool.path("pool.exr")
    pool.same("three nodes, one behind a line", out, pool.render(out, nodes=3))

    def cut():
        line.cut = True
        threading.Timer(5.0, lambda: setattr(line, "cut", False)).start()

    result, seconds, _ = pool.disturbed("the network of a node is cut for 5 s", cut, 3)
    print(f"network cut for 5 s: {seconds:.2f} s in all, tiles {result.get('tiles')}")
    while line.cut:
        time.sleep(0.1)
    pool.same("the network is back, so is the node", out, pool.render(out, nodes=3))
    line.rate = 10e6
    result, seconds, _ = pool.disturbed("a line of 10 Mbit/s", lambda: None, 3)
    print(f"line of 10 Mbit/s: {seconds:.2f} s in all, tiles {result.get('tiles')}")
    pool.end_node("far")
    line.end()


def liars(pool):
    """What is damaged on its way to a node is told from what is sound, and costs the head nothing."""
    line = Line(pool.broker, damage_chunks=True)
    deceived = pool.node("deceived", broker=line, cache="empty")
    out = pool.path("pool.exr")
    pool.same("a node whose parts of the scene come damaged", out, pool.render(out, nodes=3))
    pool.check("parts were damaged", line.damaged > 0)
    pool.check("the node says what is wrong", "came damaged" in pool.log("deceived"), pool.log("deceived")[-300:])
    pool.check("the node lives", deceived.poll() is None)
    pool.end_node("deceived")
    line.end()


def strangers(pool):
    stranger = Stranger(pool.broker)
    stranger.subscribe("heliograph.pool.>", 1)
    random.seed(18)
    made = pool.start(pool.path("garbage.exr"), nodes=2)
    subjects = {"heliograph.pool.nodes", "heliograph.pool.heads"}
    heard = {"head": 0, "node": 0}
    for subject, data in stranger.messages(LONGEST):
        if subject.endswith(".nodes"):
            subjects.add("heliograph.pool.node." + peer_of(data))
        if subject.endswith(".heads"):
            subjects.update(f"heliograph.pool.{kind}.{peer_of(data)}" for kind in ("head", "scene"))
        heard = {kind: sum(f".{kind}." in subject for subject in subjects) for kind in ("head", "node")}
        if heard["head"] >= 1 and heard["node"] >= 2:
            break
    pool.check("a head and two nodes are heard", heard["head"] == 1 and heard["node"] == 2, subjects)
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
    write(wrong, "pool:another long secret\n")
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


def said_by(pool, words, arguments):
    """What a command says that is refused at its start."""
    return subprocess.run([PROGRAM, *words, *arguments], capture_output=True, text=True, timeout=LONGEST, check=False)


def secrets(pool):
    """TLS, tokens, certificates: the right ones make a picture, others are refused with the reason."""
    ours, others = Authority(pool.folder, "ours"), Authority(pool.folder, "others")
    certificate, key = ours.sign("broker", "IP:127.0.0.1")
    broker = Broker(pool.folder, secret="token", tls={"cert_file": certificate, "key_file": key})
    right = [*broker.arguments(), "--pool-ca", ours.certificate]
    pool.remote("TLS and a token", broker, right)
    wrong = pool.path("wrong.secret")
    write(wrong, "another long secret\n")
    refused = {"a wrong token": (["--pool", broker.url, "--pool-secret", wrong, "--pool-ca", ours.certificate], "refuses who comes"),
               "a broker whose certificate others signed": ([*broker.arguments(), "--pool-ca", others.certificate], "certificate"),
               "a broker of an unknown authority": (broker.arguments(), "certificate"),
               "a line without TLS": (["--pool", broker.url.replace("tls", "nats"), "--pool-secret", broker.secret], "certificate")}
    broker_of_others = Broker(pool.folder, secret="token", tls=dict(zip(("cert_file", "key_file"), ours.sign("other", "DNS:other.example"))))
    refused["a certificate for another name"] = ([*broker_of_others.arguments(), "--pool-ca", ours.certificate], "certificate")
    strict = Broker(pool.folder, secret="", tls={"cert_file": certificate, "key_file": key, "ca_file": ours.certificate, "verify": True})
    mine = ours.sign("node", "DNS:node")
    pool.remote("TLS and a certificate of our own", strict, ["--pool", strict.url, "--pool-ca", ours.certificate, "--pool-cert", mine[0], "--pool-key", mine[1]])
    stranger = others.sign("node", "DNS:node")
    refused["a certificate that others signed"] = (
        ["--pool", strict.url, "--pool-ca", ours.certificate, "--pool-cert", stranger[0], "--pool-key", stranger[1]], "certificate")
    for name, (arguments, reason) in refused.items():
        said = said_by(pool, ["node"], arguments)
        pool.check(name, said.returncode == 2 and reason in said.stderr, said.stderr)
    for one in (broker, broker_of_others, strict):
        one.stop()


def open_brokers(pool):
    """A broker that lets everybody in is taken on this machine alone."""
    host = own_address()
    if host is None:
        print("not run: this machine has no address but its loopback")
        return
    broker = Broker(pool.folder, host=host, secret="")
    said = said_by(pool, ["node"], ["--pool", broker.url, "--pool-secret", pool.broker.secret])
    pool.check("an open broker elsewhere", said.returncode == 2 and "lets everybody in" in said.stderr, said.stderr)
    pool.remote("an open broker elsewhere that was allowed", broker, ["--pool", broker.url, "--pool-insecure"])
    broker.stop()


def died_frame(pool):
    pool.render(pool.path("one.exr"), pool=False, device="embree", picture=timeline.PICTURE)
    pool.use_reference(pool.path("one.exr"))
    timeline.frame(pool, pool.path("timeline.svg"))
    pool.use_reference(pool.local)
    kept = os.path.join("out", "check")
    if os.path.isdir(kept):
        shutil.copy(pool.path("timeline.svg"), os.path.join(kept, "pool-timeline.svg"))
    pool.end_nodes()


def delays(pool):
    figures.delays(pool, PROGRAM)


PARTS = (pictures, dying_nodes, dying_broker, bad_lines, liars, strangers, refusals, secrets, open_brokers, died_frame,
         figures.scaling)
ASKED = (figures.cost, figures.joining, figures.compression, delays)  # only when asked for: they take minutes, and a quiet machine


def parts_of(names):
    every = {part.__name__: part for part in PARTS + ASKED}
    unknown = [name for name in names if name not in every]
    if unknown:
        raise SystemExit(f"no such part: {', '.join(unknown)}; allowed: {' '.join(every)}")
    return [every[name] for name in names] or PARTS


def main():
    folder = tempfile.mkdtemp(prefix="heliograph-pool-")
    pool = Pool(folder)
    try:
        for part in parts_of(sys.argv[3:]):
            begin = time.monotonic()
            part(pool)
            print(f"  {part.__name__}: {time.monotonic() - begin:.1f} s")
    finally:
        pool.end_nodes()
        pool.broker.stop()
        shutil.rmtree(folder)
    print(f"{pool.passed} passed, {pool.failed} failed")
    sys.exit(pool.failed > 0 or pool.passed == 0)


main()
