"""A line between a node and the broker that can be cut, be slow, and damage what goes over it."""

import re
import socket
import threading
import time

from broker import CHUNK, HEADER, check_sum, kind_of

PIECE = 8192  # bytes handed on at once


class Line:
    """Listens on a port of its own (`url`) and hands on to the broker. `cut`: nothing goes through, nobody is told: as a network
    that is gone; what waits goes on when it is back. `rate`: bits a second, each way. `damage_chunks`: a byte of each part of a
    scene is turned on its way from the broker."""

    def __init__(self, broker, rate=None, damage_chunks=False):
        self.broker, self.rate, self.damage_chunks = broker, rate, damage_chunks
        self.cut = self.over = False
        self.damaged = 0
        self.listener = socket.socket()
        self.listener.bind(("127.0.0.1", 0))
        self.listener.listen()
        self.url = f"nats://127.0.0.1:{self.listener.getsockname()[1]}"
        threading.Thread(target=self.accept, daemon=True).start()

    def arguments(self):
        return ["--pool", self.url, "--pool-secret", self.broker.secret]

    def accept(self):
        while not self.over:
            try:
                near, _ = self.listener.accept()
                far = socket.create_connection((self.broker.host, self.broker.port), 5)
            except OSError:
                continue
            for end in (near, far):
                end.settimeout(None)
                for option in (socket.SO_RCVBUF, socket.SO_SNDBUF):
                    end.setsockopt(socket.SOL_SOCKET, option, 64 * 1024)
            threading.Thread(target=self.pump, args=(near, far, lambda data: data), daemon=True).start()
            damage = self.damager() if self.damage_chunks else lambda data: data
            threading.Thread(target=self.pump, args=(far, near, damage), daemon=True).start()

    def pump(self, source, target, change):
        free = time.monotonic()
        try:
            while not self.over:
                data = source.recv(PIECE)
                if not data:
                    break
                while self.cut and not self.over:
                    time.sleep(0.01)
                if self.rate:
                    free = max(free, time.monotonic()) + 8 * len(data) / self.rate
                    time.sleep(max(free - time.monotonic(), 0))
                target.sendall(change(data))
        except OSError:
            pass
        for end in (source, target):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    def damager(self):
        """A function over the stream from the broker; it may hold bytes back until their message is whole."""
        waiting = bytearray()

        def change(data):
            waiting.extend(data)
            out = bytearray()
            while b"\r\n" in waiting:
                end = waiting.index(b"\r\n") + 2
                match = re.match(rb"MSG \S+ \d+ (?:\S+ )?(\d+)\r\n", waiting[:end])
                if not match:
                    out += waiting[:end]
                    del waiting[:end]
                    continue
                whole = end + int(match[1]) + 2
                if len(waiting) < whole:
                    break
                index = bytes(waiting[end + HEADER + 32:end + HEADER + 36])  # behind the scene's name; the list of parts has the last
                if kind_of(bytes(waiting[end:whole])) == CHUNK and index != b"\xff" * 4:
                    self.damage(waiting, end + HEADER, whole - 2)
                out += waiting[:whole]
                del waiting[:whole]
            return bytes(out)

        return change

    def damage(self, message, begin, end):
        """The part, behind the scene's name and its number; the message's own sum is made right again, as one who lies would."""
        message[end - 1] ^= 1
        message[begin - 8:begin] = check_sum(bytes(message[begin:end])).to_bytes(8, "little")
        self.damaged += 1

    def end(self):
        self.over = True
        self.listener.close()
