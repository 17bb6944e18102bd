#!/usr/bin/env python3
"""For a bounded time parts of a running server are killed, stalled or starved; after each fault four things must hold: the
process lives, the last input of a viewer who watches is answered, its picture is that of an undisturbed server bit for bit,
and at the end no descriptor, no thread and no memory has leaked. Prints a table, fault by invariant.

chaos.py [--seconds 60] [--seed 1] [--scene cornell] [--devices LIST]; HELIOGRAPH names the program. Exit code 1: one broke."""
import argparse, os, random, resource, signal, socket, struct, sys, threading, time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'operations'))
import support

PATIENCE = 30.0  # seconds after which an answer counts as missing
SAMPLES = 4
LEAK_MIB = 96  # what memory may stay above that before the faults: pools and arenas that are kept


class Watcher(support.Viewer):
    """Knows the newest frame and keeps the pictures it asked for."""

    def __init__(self, port, size=(160, 96)):
        super().__init__(port, size=size)
        self.input, self.newest, self.samples, self.pictures = 1, 0, 0, []

    def take(self, kind, payload, acknowledge):
        if kind == 2 and payload[2] == 2:
            self.pictures.append(payload[64:])
        elif kind == 2:
            frame, self.newest = struct.unpack_from('<II', payload, 8)
            self.samples = struct.unpack_from('<I', payload, 28)[0]
            if acknowledge:
                self.say(type='ack', frameId=frame, presentedMs=None)

    def look(self):
        self.input += 1
        self.camera(self.input)

    def answered(self):
        self.read(PATIENCE, lambda: self.newest >= self.input)
        return self.newest >= self.input

    def picture(self):
        """PNG of a fixed view with SAMPLES samples; nothing where none came."""
        self.input += 1
        self.say(type='settings', inputId=self.input, values={'samples': SAMPLES})
        self.input += 1
        self.say(type='camera', inputId=self.input, position=[0.1, 1, 3], forward=[0, 0, -1], up=[0, 1, 0], fieldOfView=60,
                 moving=False)
        self.read(PATIENCE, lambda: self.newest >= self.input and self.samples >= SAMPLES)
        count = len(self.pictures)
        self.say(type='picture', format='png')
        self.read(PATIENCE, lambda: len(self.pictures) > count)
        return self.pictures[-1] if len(self.pictures) > count else None

    def cut(self):
        """Without a goodbye."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack('ii', 1, 0))
        self.socket.close()


class Fault:
    def __init__(self, server, rng):
        self.server, self.rng = server, rng

    def status(self, field):
        with open('/proc/%d/status' % self.server.process.pid) as f:
            return next(int(line.split()[1]) for line in f if line.startswith(field + ':'))

    def viewers_killed(self):
        for _ in range(6):
            viewer = Watcher(self.server.port, (self.rng.randrange(64, 640), self.rng.randrange(64, 360)))
            for _ in range(self.rng.randrange(1, 8)):
                viewer.look()
            viewer.read(self.rng.random() * 0.2)
            viewer.cut()

    def viewer_stalls(self):
        viewer = Watcher(self.server.port, (640, 360))
        for _ in range(40):
            viewer.look()  # reads nothing
            time.sleep(0.02)
        viewer.cut()

    def scenes_storm(self):
        viewer = Watcher(self.server.port)
        names = ['glass', 'courtyard', 'cornell']
        for _ in range(40):
            viewer.say(type='scene', name=self.rng.choice(names))
            time.sleep(0.01)
        viewer.cut()

    def dear_settings(self):
        viewer = Watcher(self.server.port, (640, 360))
        viewer.input += 1
        viewer.say(type='settings', inputId=viewer.input, values={
            'samples': 65536, 'tileWidth': '256', 'tileHeight': '256', 'shadowSamples': 256, 'ambientOcclusion': True,
            'aoSamples': 256, 'maxReflections': 31, 'maxRefractions': 31, 'contributionThreshold': 0})
        viewer.read(2.0)
        viewer.cut()

    def process_stopped(self):
        self.server.send(signal.SIGSTOP)
        time.sleep(0.5 + self.rng.random())
        self.server.send(signal.SIGCONT)

    def descriptors(self):
        pid = self.server.process.pid
        before = resource.prlimit(pid, resource.RLIMIT_NOFILE)
        resource.prlimit(pid, resource.RLIMIT_NOFILE, (len(os.listdir('/proc/%d/fd' % pid)) + 4, before[1]))
        held = []
        for _ in range(40):
            s = socket.socket()
            s.settimeout(0.2)
            try:
                s.connect(('127.0.0.1', self.server.port))
                held.append(s)
            except OSError:
                s.close()
        time.sleep(0.5)
        for s in held:
            s.close()
        resource.prlimit(pid, resource.RLIMIT_NOFILE, before)

    def memory(self):
        pid = self.server.process.pid
        before = resource.prlimit(pid, resource.RLIMIT_AS)
        resource.prlimit(pid, resource.RLIMIT_AS, (self.status('VmSize') * 1024 + (48 << 20), before[1]))
        viewers = []
        try:
            for i in range(8):
                viewers.append(Watcher(self.server.port, (3840, 2160)))
                viewers[-1].read(0.2)
        except (OSError, RuntimeError, ValueError, IndexError):
            pass  # refused
        for viewer in viewers:
            viewer.cut()
        time.sleep(0.3)
        resource.prlimit(pid, resource.RLIMIT_AS, before)


FAULTS = ['viewers_killed', 'viewer_stalls', 'scenes_storm', 'dear_settings', 'process_stopped', 'descriptors', 'memory']


def undisturbed(arguments, options):
    server = support.Server(*arguments, scene=options.scene)
    picture = Watcher(server.port).picture()
    code, _ = server.end()
    if picture is None or code != 0:
        raise SystemExit('the undisturbed server gave no picture: ' + server.log()[-500:])
    return picture


def full_disk(arguments, options, reference):
    """Standard error goes to a full disk."""
    with open('/dev/full', 'w') as full:
        original = support.subprocess.Popen
        support.subprocess.Popen = lambda *a, **k: original(*a, **{**k, 'stderr': full})
        try:
            server = support.Server(*arguments, '--log', 'debug', scene=options.scene)
        finally:
            support.subprocess.Popen = original
    watcher = Watcher(server.port)
    watcher.look()
    answered, picture = watcher.answered(), watcher.picture()
    code, _ = server.end()
    row('disk full (log)', code == 0, answered, picture == reference)


def row(fault, alive, answered, same):
    words = {True: 'holds', False: 'BROKEN'}
    print('| %-18s | %-7s | %-9s | %-7s |' % (fault, words[alive], words[answered], words[same]), flush=True)
    for name, good in (('alive', alive), ('answered', answered), ('same picture', same)):
        support.checks.append(fault + ': ' + name)
        if not good:
            support.failures.append(fault + ': ' + name)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('--seconds', type=float, default=60.0)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--scene', default='cornell')
    parser.add_argument('--devices', default='')
    options = parser.parse_args()
    rng = random.Random(options.seed)
    arguments = ['--devices', options.devices] if options.devices else []
    reference = undisturbed(arguments, options)
    print('| fault              | process | last input | picture |\n| --- | --- | --- | --- |', flush=True)
    full_disk(arguments, options, reference)
    server = support.Server(*arguments, scene=options.scene)
    watcher = Watcher(server.port)
    watcher.answered()
    fault = Fault(server, rng)
    for name in FAULTS[:4]:
        getattr(fault, name)()  # pools and arenas are there then
    watcher.answered()
    time.sleep(3)
    descriptors, threads = len(os.listdir('/proc/%d/fd' % server.process.pid)), fault.status('Threads')
    memory = fault.status('VmRSS')
    end, turn = time.monotonic() + options.seconds, 0
    while time.monotonic() < end and server.process.poll() is None:
        name = FAULTS[turn] if turn < len(FAULTS) else rng.choice(FAULTS)  # each one at least, if there is time
        turn += 1
        # The watcher moves all the while, and reads.
        over = threading.Event()
        worker = threading.Thread(target=lambda: (getattr(fault, name)(), over.set()))
        worker.start()
        while not over.is_set() and watcher.closed is None and worker.is_alive():
            watcher.look()
            watcher.read(0.05)
        worker.join()
        if watcher.closed is not None or server.process.poll() is not None:
            row(name, server.process.poll() is None, False, False)
            break
        watcher.look()
        answered = watcher.answered()
        row(name, server.process.poll() is None, answered, watcher.picture() == reference)
    if server.process.poll() is None:
        settled = support.until(lambda: fault.status('Threads') <= threads + 2
                                and len(os.listdir('/proc/%d/fd' % server.process.pid)) <= descriptors + 2, PATIENCE)
        support.check('no thread and no descriptor leaked', settled is not None, '%d threads and %d descriptors before, %d and %d after' % (
            threads, descriptors, fault.status('Threads'), len(os.listdir('/proc/%d/fd' % server.process.pid))))
        support.check('no memory leaked', fault.status('VmRSS') <= memory + LEAK_MIB * 1024,
                      '%d MiB before, %d after' % (memory // 1024, fault.status('VmRSS') // 1024))
        support.check('it ends well', server.end()[0] == 0)
    else:
        print(server.log()[-2000:])
    support.finish()


if __name__ == '__main__':
    main()
