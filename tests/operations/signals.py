#!/usr/bin/env python3
"""SIGTERM and SIGINT with viewers, while loading and twice; what a service manager is told. tests/operations/signals.py"""
import os, signal, socket, tempfile, threading, time
from support import Server, Viewer, check, finish, until


def drain():
    server = Server()
    viewers = [Viewer(server.port) for _ in range(3)]
    for v in viewers:
        v.read(20, lambda: 1 in v.inputs)
    for i in range(2, 12):
        for v in viewers:
            v.camera(i)
    for v in viewers:
        v.read(20, lambda: v.inputs and v.inputs[-1] == 11)
        v.camera(12)
    time.sleep(0.05)
    start = time.monotonic()
    server.send(signal.SIGTERM)
    readers = [threading.Thread(target=v.read, args=(5,)) for v in viewers]
    for reader in readers:
        reader.start()
    for reader in readers:
        reader.join()
    code = server.process.wait(10)
    seconds = time.monotonic() - start
    check('SIGTERM with three viewers: exit code 0', code == 0, code)
    check('... within 2 s', seconds <= 2.0, '%.2f s' % seconds)
    for v in viewers:
        check('... a viewer is told', any(t['type'] == 'notice' and 'endsInMs' in t for t in v.texts))
        check('... has the answer to its last input', v.inputs[-1] == 12, v.inputs[-1])
        check('... and is closed with 1001', v.closed == 1001, v.closed)


def stubborn():
    """A viewer that acknowledges nothing, with dear settings: the end comes all the same."""
    server = Server(scene='courtyard')
    v = Viewer(server.port, size=(1280, 720))
    v.say(type='settings', inputId=2, values=dict(samples=4096))
    v.read(2, acknowledge=False)
    code, seconds = server.end()
    check('SIGTERM with a viewer that acknowledges nothing', code == 0 and seconds <= 2.0, 'code %d, %.2f s' % (code, seconds))


def twice():
    server = Server(scene='courtyard')
    v = Viewer(server.port, size=(1280, 720))
    v.read(2, lambda: v.inputs, acknowledge=False)
    server.send(signal.SIGINT)
    time.sleep(0.1)
    code, seconds = server.end(signal.SIGINT)
    check('a second SIGINT ends at once', code == 0 and seconds < 0.8, 'code %d, %.2f s' % (code, seconds))


def loading():
    for delay in (0.0, 0.01, 0.05, 0.2, 0.5):
        server = Server(scene='cathedral', wait=False)
        time.sleep(delay)
        code, seconds = server.end()
        # Before the signals are blocked the system's own answer holds.
        good = code == 0 or (delay < 0.05 and code == -signal.SIGTERM)
        check('SIGTERM %.2f s after the start, while it loads' % delay, good and seconds <= 2.0, 'code %d, %.2f s' % (code, seconds))


def manager():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, 'notify')
        ear = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        ear.bind(path)
        ear.setblocking(False)
        heard = []

        def listen():
            try:
                while True:
                    heard.append(ear.recv(4096).decode())
            except BlockingIOError:
                return heard

        server = Server(environment={'NOTIFY_SOCKET': path, 'WATCHDOG_USEC': '400000'})
        check('READY=1 when the scene is there', until(lambda: any(m.startswith('READY=1\nSTATUS=serving cornell on http') for m in listen())))
        began, before = time.monotonic(), listen().count('WATCHDOG=1')
        time.sleep(2)
        beats, right = listen().count('WATCHDOG=1') - before, (time.monotonic() - began) / 0.2
        check('WATCHDOG=1 at half of WATCHDOG_USEC', right / 2 <= beats <= right * 1.5, '%d, not %.1f' % (beats, right))
        server.end()
        check('STOPPING=1 at the end', any(m.startswith('STOPPING=1') for m in listen()))


def port_in_use():
    server = Server()
    other = Server(port=server.port, wait=False)
    code = other.process.wait(20)
    line = other.log().strip().split('\n')[-1]
    check('a port in use: exit code 2, and who has it', code == 2 and 'pid %d' % server.process.pid in line, line)
    server.end()
    if os.geteuid() != 0:
        low = Server(port=80, wait=False)
        code = low.process.wait(20)
        check('a privileged port: exit code 2 and why', code == 2 and 'privileged' in low.log(), low.log().strip())


if __name__ == '__main__':
    for part in (drain, stubborn, twice, loading, manager, port_in_use):
        part()
    finish()
