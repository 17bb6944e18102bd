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
VERSION = 1
BATCH_END = 11  # server/pool/wire/messages.h


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Broker:
    """nats-server with a user and a password; can be stopped and started again on its port."""

    def __init__(self, folder, host="127.0.0.1", secret=True):
        self.folder, self.host, self.port = folder, host, free_port()
        self.url = f"nats://{host}:{self.port}"
        self.configuration = os.path.join(folder, f"nats-{self.port}.conf")
        self.secret = os.path.join(folder, "pool.secret") if secret else ""
        text = f'host: "{host}"\nport: {self.port}\n'
        if secret:
            text += 'authorization { user: pool, password: "a long secret of the check" }\n'
            with open(self.secret, "w", encoding="utf-8") as file:
                file.write("pool:a long secret of the check\n")
        with open(self.configuration, "w", encoding="utf-8") as file:
            file.write(text)
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


class Stranger:
    """A client of the broker."""

    def __init__(self, broker):
        self.socket = socket.create_connection((broker.host, broker.port), 5)
        self.file = self.socket.makefile("rb")
        self.file.readline()
        self.socket.sendall(
            b"CONNECT " + json.dumps({"verbose": False, "user": "pool", "pass": "a long secret of the check"}).encode() + b"\r\n")
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


def message(kind, data):
    return struct.pack("<IHH", MAGIC, VERSION, kind) + data


def kind_of(data):
    return struct.unpack_from("<H", data, 6)[0] if len(data) >= 8 else 0


def peer_of(beat):
    return "%016x" % struct.unpack_from("<Q", beat, 8)[0]
