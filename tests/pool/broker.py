"""What the pool's checks need of NATS: a broker of their own, and a line to it that speaks the protocol by hand, as a stranger
would."""

import json
import os
import re
import signal
import socket
import struct
import subprocess
import threading
import time

MAGIC = 0x4C504C48
VERSION = 2
HEADER = 16  # bytes
NODE_BEAT, CHUNK, BATCH, TILES, BATCH_END = 1, 7, 8, 10, 11  # server/pool/wire/messages.h


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


SECRET = "a long secret of the check"


def own_address():
    """Of this machine on a network; nothing is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
        except OSError:
            return None
        return probe.getsockname()[0]


class Broker:
    """nats-server; can be stopped and started again on its port. `secret`: what it asks for: "user" (and password), "token" or
    "" (nothing). `tls`: files {cert_file, key_file, ca_file, verify} of its configuration."""

    def __init__(self, folder, host="127.0.0.1", secret="user", tls=None):
        self.folder, self.host, self.port = folder, host, free_port()
        self.url = f"{'tls' if tls else 'nats'}://{host}:{self.port}"
        self.configuration = os.path.join(folder, f"nats-{self.port}.conf")
        self.secret = os.path.join(folder, f"pool-{self.port}.secret") if secret else ""
        text = f'host: "{host}"\nport: {self.port}\n'
        asked = {"user": f'user: pool, password: "{SECRET}"', "token": f'token: "{SECRET}"'}
        if secret:
            text += f"authorization {{ {asked[secret]} }}\n"
            write(self.secret, ("pool:" if secret == "user" else "") + SECRET + "\n")
        if tls:
            text += "tls { " + ", ".join(f"{key}: {json.dumps(value)}" for key, value in tls.items()) + " }\n"
        write(self.configuration, text)
        self.start()

    def start(self):
        with open(os.path.join(self.folder, "nats.log"), "ab") as log:
            self.process = subprocess.Popen(["nats-server", "-c", self.configuration], stdout=log, stderr=log)
        for _ in range(100):
            try:
                socket.create_connection((self.host, self.port), 1).close()
                return
            except OSError:
                time.sleep(0.05)
        raise SystemExit("nats-server does not listen")

    def stop(self, kind=signal.SIGTERM):
        self.process.send_signal(kind)
        self.process.wait()

    def arguments(self):
        return ["--pool", self.url] + (["--pool-secret", self.secret] if self.secret else [])


class Authority:
    """Signs certificates, as a pool's owner would."""

    def __init__(self, folder, name):
        self.folder, self.name = folder, name
        self.certificate, self.key = self.path("ca.pem"), self.path("ca.key")
        openssl("req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", f"/CN={name}", "-keyout", self.key,
                "-out", self.certificate)

    def path(self, what):
        return os.path.join(self.folder, f"{self.name}-{what}")

    def sign(self, name, alternative):
        """(certificate, key) for `alternative`, as IP:127.0.0.1."""
        certificate, key, request, extensions = (self.path(f"{name}.{kind}") for kind in ("pem", "key", "csr", "ext"))
        write(extensions, f"subjectAltName={alternative}\n")
        openssl("req", "-newkey", "rsa:2048", "-nodes", "-subj", f"/CN={name}", "-keyout", key, "-out", request)
        openssl("x509", "-req", "-in", request, "-CA", self.certificate, "-CAkey", self.key, "-CAcreateserial", "-days", "2",
                "-extfile", extensions, "-out", certificate)
        return certificate, key


def openssl(*words):
    subprocess.run(["openssl", *words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def write(path, text):
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


class Stranger:
    """A client of the broker."""

    def __init__(self, broker):
        self.socket = socket.create_connection((broker.host, broker.port), 5)
        self.file = self.socket.makefile("rb")
        self.file.readline()
        self.socket.sendall(
            b"CONNECT " + json.dumps({"verbose": False, "user": "pool", "pass": SECRET}).encode() + b"\r\n")
        self.lock = threading.Lock()

    def publish(self, subject, data):
        self.publish_all([(subject, data)])

    def publish_all(self, messages):
        with self.lock:
            self.socket.sendall(b"".join(b"PUB %s %d\r\n%s\r\n" % (s.encode(), len(d), d) for s, d in messages))

    def subscribe(self, subject, number):
        with self.lock:
            self.socket.sendall(b"SUB %s %d\r\n" % (subject.encode(), number))

    def messages(self, seconds):
        """(subject, data) until the time is over."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.socket.settimeout(max(end - time.monotonic(), 0.01))
            try:
                line = self.file.readline()
            except OSError:
                return
            if not line:  # the broker has ended
                return
            if line.startswith(b"PING"):
                with self.lock:
                    self.socket.sendall(b"PONG\r\n")
            match = re.match(rb"MSG (\S+) \d+ (\d+)", line)
            if match:
                self.socket.settimeout(5)
                data = self.file.read(int(match[2]) + 2)[:-2]
                yield match[1].decode(), data

    def close(self):
        self.socket.close()


def check_sum(data):
    """As server/pool/wire/check_sum.h."""
    mask = (1 << 64) - 1

    def mixed(total, word):
        total ^= word
        return ((total << 31 | total >> 33) & mask) * 0x9E3779B97F4A7C15 & mask

    lanes = [1, 2, 3, 4]
    words = struct.unpack(f"<{len(data) // 32 * 4 + 4}Q", data + bytes(32 - len(data) % 32))
    for at in range(0, len(words) - 4, 4):
        lanes = [mixed(lane, word) for lane, word in zip(lanes, words[at:at + 4])]
    total = len(data)
    for lane, word in zip(lanes, words[-4:]):
        total = mixed(total, mixed(lane, word))
    return total


def message(kind, data):
    return struct.pack("<IHHQ", MAGIC, VERSION, kind, check_sum(data)) + data


def kind_of(data):
    return struct.unpack_from("<H", data, 6)[0] if len(data) >= 8 else 0


def peer_of(beat):
    return "%016x" % struct.unpack_from("<Q", beat, HEADER)[0]
