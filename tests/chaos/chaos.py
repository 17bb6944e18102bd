#!/usr/bin/env python3
"""For a bounded time parts of a running server are killed, stalled or starved; after each fault four things must hold: the
process lives, the last input of a viewer who watches is answered, its picture is that of an undisturbed server bit for bit,
and at the end no descriptor, no thread and no memory has leaked. Prints a table, fault by invariant.

Threads and devices are taken away by control groups of version 1, which takes root; without them it is said what was
not run.

chaos.py [--seconds 60] [--seed 1] [--scene cornell] [--devices LIST]; HELIOGRAPH names the program. Exit code 1: one broke."""
import argparse, os, random, resource, signal, socket, statistics, struct, sys, threading, time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'operations'))
import support

PATIENCE = 30.0  # seconds after which an answer counts as missing
SAMPLES = 4
LEAK_MIB = 48  # what the median of the last quarter may be above that of the second one: scenes come and go


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


class ControlGroup:
    """A control group (version 1, as root) for processes or, with `freezer`, for single threads; gone at the end."""

    def __init__(self, controller):
        self.folder = '/sys/fs/cgroup/%s/heliograph-chaos-%d' % (controller, os.getpid())
        self.controller = controller

    def __enter__(self):
        os.makedirs(self.folder, exist_ok=True)
        return self

    def write(self, file, value):
        with open(os.path.join(self.folder, file), 'w') as f:
            f.write(str(value))

    def __exit__(self, *_):
        for file in ('tasks', 'cgroup.procs'):
            with open(os.path.join(self.folder, file)) as f:
                for member in f.read().split():
                    try:
                        with open('/sys/fs/cgroup/%s/%s' % (self.controller, file), 'w') as parent:
                            parent.write(member)
                    except ProcessLookupError:
                        pass  # a thread that has ended meanwhile
        os.rmdir(self.folder)

    @staticmethod
    def here(controller):
        return os.access('/sys/fs/cgroup/%s/cgroup.procs' % controller, os.W_OK)


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

    def threads_short(self):
        """No thread is to be had for whoever comes; those inside have theirs."""
        with ControlGroup('pids') as group:
            group.write('cgroup.procs', self.server.process.pid)
            group.write('pids.max', self.status('Threads') + 1)
            for _ in range(12):
                try:
                    Watcher(self.server.port).cut()
                except (OSError, RuntimeError, ValueError, IndexError):
                    pass  # refused
            group.write('pids.max', 'max')

    def device_stalls(self):
        """The threads of the software Vulkan device stand still; the rest of the process runs."""
        with ControlGroup('freezer') as group:
            for thread in self.device_threads():
                group.write('tasks', thread)
            group.write('freezer.state', 'FROZEN')
            time.sleep(1 + self.rng.random())
            group.write('freezer.state', 'THAWED')

    def device_threads(self):
        folder = '/proc/%d/task' % self.server.process.pid
        found = []
        for thread in os.listdir(folder):
            with open(os.path.join(folder, thread, 'comm')) as f:
                if f.read().startswith('llvmpipe'):
                    found.append(thread)
        return found

    def possible(self):
        """Names of the faults that can be made here, and why others cannot."""
        names, missing = list(FAULTS), []
        if not ControlGroup.here('pids'):
            missing.append('threads_short: no control group pids')
        if not ControlGroup.here('freezer') or not self.device_threads():
            missing.append('device_stalls: no software Vulkan device among --devices, or no control group freezer')
        return [n for n in names if not any(m.startswith(n) for m in missing)], missing

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


FAULTS = ['viewers_killed', 'viewer_stalls', 'scenes_storm', 'dear_settings', 'process_stopped', 'descriptors', 'memory',
          'threads_short', 'device_stalls']


def make(fault, name, watcher):
    """The watcher moves all the while, and reads."""
    worker = threading.Thread(target=getattr(fault, name))
    worker.start()
    try:
        while watcher.closed is None and worker.is_alive():
            watcher.look()
            watcher.read(0.05)
    except OSError as error:
        watcher.closed = 'without a word (%s)' % error
    worker.join()


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


def little_memory(arguments, options, reference):
    """A control group of 1,500 MiB, in which a viewer asks for the largest picture there is."""
    if not ControlGroup.here('memory'):
        print('not run: memory by control group, which is not here')
        return
    with ControlGroup('memory') as group:
        group.write('memory.limit_in_bytes', 1500 << 20)
        group.write('cgroup.procs', os.getpid())  # the server is started inside
        try:
            server = support.Server(*arguments, scene=options.scene)
        finally:
            with open('/sys/fs/cgroup/memory/cgroup.procs', 'w') as parent:
                parent.write(str(os.getpid()))
        watcher, large = Watcher(server.port), Watcher(server.port, (8192, 4050))
        end = time.monotonic() + 10
        while time.monotonic() < end and large.closed is None:
            large.look()
            large.read(0.3)
            watcher.read(0.1)  # one who reads nothing for 10 s is closed
        watcher.look()
        answered, picture = watcher.answered(), watcher.picture()
        large.cut()
        code, _ = server.end()
        row('memory (cgroup)', code == 0, answered, picture == reference)


def killed(arguments):
    """kill -9, and a start on the same port: how long until it serves, with a scene of 70,000 triangles."""
    server = support.Server(*arguments, scene='courtyard')
    watcher = Watcher(server.port)
    answered_before = watcher.answered()
    port = server.port
    server.send(signal.SIGKILL)
    server.process.wait()
    begin = time.monotonic()
    again = support.Server(*arguments, scene='courtyard', port=port)
    serving = time.monotonic() - begin
    watcher = Watcher(port)
    watcher.look()
    answered = watcher.answered()
    print('after kill -9: serving the courtyard after %.2f s, first frame after %.2f s' % (serving, time.monotonic() - begin))
    row('killed (-9)', again.end()[0] == 0, answered_before and answered, True)


rows = {}  # fault: how often, and how often each invariant held


def summary():
    print('| fault | times | process lives | last input answered | same picture |\n| --- | ---: | ---: | ---: | ---: |')
    for fault, held in rows.items():
        print('| %s | %d | %d | %d | %d |' % ((fault, len(held)) + tuple(sum(column) for column in zip(*held))))


def row(fault, alive, answered, same):
    rows.setdefault(fault, []).append((alive, answered, same))
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
    little_memory(arguments, options, reference)
    killed(arguments)
    server = support.Server(*arguments, scene=options.scene)
    watcher = Watcher(server.port)
    watcher.answered()
    fault = Fault(server, rng)
    names, missing = fault.possible()
    for why in missing:
        print('not run: ' + why, flush=True)
    for name in names:
        make(fault, name, watcher)  # pools and arenas are there then
    watcher.answered()
    time.sleep(3)
    descriptors, threads = len(os.listdir('/proc/%d/fd' % server.process.pid)), fault.status('Threads')
    memory = []
    end, turn, settled_threads = time.monotonic() + options.seconds, 0, 0
    while time.monotonic() < end and server.process.poll() is None:
        name = names[turn] if turn < len(names) else rng.choice(names)  # each one at least, if there is time
        turn += 1
        if time.monotonic() > end - options.seconds / 2 and not settled_threads:
            settled_threads = fault.status('Threads')  # by now there are as many as ever were busy at once; they are kept
        make(fault, name, watcher)
        if watcher.closed is not None or server.process.poll() is not None:
            row(name, server.process.poll() is None, False, False)
            print('the watcher was closed: %s; the server: %s\n%s' % (watcher.closed, server.process.poll(), server.log()[-4000:]))
            break
        watcher.look()
        answered = watcher.answered()
        memory.append(fault.status('VmRSS') / 1024)
        row(name, server.process.poll() is None, answered, watcher.picture() == reference)
    summary()
    if server.process.poll() is None:
        threads = max(threads, settled_threads)
        settled = support.until(lambda: fault.status('Threads') <= threads + 2
                                and len(os.listdir('/proc/%d/fd' % server.process.pid)) <= descriptors + 2, PATIENCE)
        support.check('no thread and no descriptor leaked', settled is not None, '%d threads and %d descriptors before, %d and %d after' % (
            threads, descriptors, fault.status('Threads'), len(os.listdir('/proc/%d/fd' % server.process.pid))))
        quarter = max(1, len(memory) // 4)
        quarters = [statistics.median(memory[begin:begin + quarter]) for begin in range(0, 4 * quarter, quarter) if memory[begin:]]
        support.check('no memory leaked', quarters[-1] <= quarters[min(1, len(quarters) - 1)] + LEAK_MIB,
                      'medians of the quarters: %s MiB' % ', '.join('%.0f' % value for value in quarters))
        support.check('it ends well', server.end()[0] == 0)
    else:
        print(server.log()[-2000:])
    support.finish()


if __name__ == '__main__':
    main()
