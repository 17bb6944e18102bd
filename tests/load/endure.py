#!/usr/bin/env python3
"""What a server is like after long use: the processor time of idle connections, memory over connect/disconnect cycles and over a
storm of messages, the time to serve again after `kill -9`. Memory is resident memory of the process after a quarter of the way
and at the end, both after two quiet seconds.

endure.py [--parts idle,viewers,cycles,storm,soak,restart] [--cycles 10000] [--storm 600] [--soak 1800] [--connections 1000];
prints a table, and on stderr memory after each round of the soak.
HELIOGRAPH and HELIOGRAPH_LOAD name the programs. Exit code 1: memory grew by more than 5 %, or not
all viewers stayed."""
import argparse, os, random, re, signal, subprocess, sys, time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'operations'))
import support

LOAD = os.environ.get('HELIOGRAPH_LOAD', os.path.join(support.ROOT, 'build/release/tests/heliograph-load'))


def status(server, field):
    with open('/proc/%d/status' % server.process.pid) as f:
        return next(int(line.split()[1]) for line in f if line.startswith(field + ':'))


def settled(server):
    """Resident MiB, once what has gone is given back."""
    time.sleep(2)
    return status(server, 'VmRSS') / 1024


def nobody(server):
    """Waits until no view is kept for somebody who may come back."""
    end = time.monotonic() + 60
    while '\nheliograph_views 0\n' not in server.get('/metrics')[2]:
        if time.monotonic() > end:
            raise RuntimeError('views are left after a minute')
        time.sleep(0.5)


def processor(server):
    with open('/proc/%d/stat' % server.process.pid) as f:
        fields = f.read().rsplit(')', 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def row(what, before, after, note):
    print('| %s | %s | %s | %s |' % (what, before, after, note), flush=True)


def idle(options):
    """Connections that say nothing."""
    room = str(options.connections + 100)
    server = support.Server('--spare-connections', room, '--spare-connections-per-address', room)
    threads = status(server, 'Threads')
    held = [support.connect(server.port) for _ in range(options.connections)]
    time.sleep(2)
    before, seconds = processor(server), 20.0
    time.sleep(seconds)
    used = (processor(server) - before) / seconds
    row('%d silent connections' % options.connections, '%d threads' % threads, '%d threads' % status(server, 'Threads'),
        '%.2f %% of a core' % (100 * used))
    for connection in held:
        connection.close()
    server.end()
    return True


def viewers(options):
    """Viewers that have a picture and rest: they answer what they are asked, and say nothing else."""
    server = support.Server('--max-viewers', str(options.connections), '--least-rate', '0', '--set', 'samples=1')
    threads, memory = status(server, 'Threads'), settled(server)
    ramp, seconds = options.connections / 50, 40.0
    load = subprocess.Popen([LOAD, 'ws://127.0.0.1:%d/ws' % server.port, '--viewers', str(options.connections), '--ramp', str(ramp),
                             '--seconds', str(seconds + 20), '--size', '32x18', '--script', 'idle'], stdout=subprocess.DEVNULL)
    time.sleep(ramp + 10)
    before = processor(server)
    time.sleep(seconds)
    used = (processor(server) - before) / seconds
    inside = int(re.search(r'^heliograph_viewers (\d+)', server.get('/metrics')[2], re.M)[1])
    row('%d resting viewers' % inside, '%d threads, %.0f MiB' % (threads, memory),
        '%d threads, %.0f MiB' % (status(server, 'Threads'), status(server, 'VmRSS') / 1024), '%.2f %% of a core' % (100 * used))
    load.kill()
    server.end()
    return inside == options.connections


def flat(what, first, last, note):
    row(what, '%.0f MiB' % first, '%.0f MiB' % last, '%+.1f %%, %s' % (100 * (last / first - 1), note))
    return last <= 1.05 * first


def cycles(options):
    """Each connects, sees a picture and goes, one half without a goodbye."""
    server = support.Server('--set', 'samples=1', '--keep-views', '1')
    first, start = 0.0, time.monotonic()
    for number in range(options.cycles):
        viewer = support.Viewer(server.port, size=(64, 36))
        viewer.read(20.0, lambda: viewer.inputs)
        if not viewer.inputs:
            raise RuntimeError('viewer %d saw nothing' % number)
        if number % 2:
            viewer.socket.sendall(b'\x88\x82\0\0\0\0\x03\xe8')
        viewer.socket.close()
        if number == options.cycles // 4:
            nobody(server)
            first = settled(server)
    nobody(server)
    last = settled(server)
    note = '%.0f a second, %d threads' % (options.cycles / (time.monotonic() - start), status(server, 'Threads'))
    server.end()
    return flat('%d viewers one after the other' % options.cycles, first, last, note)


def storm(options):
    """Four viewers say what they can, well-formed or not, as fast as they may."""
    server = support.Server('--set', 'samples=4')
    rng, start, first, count = random.Random(1), time.monotonic(), 0.0, 0
    viewers = [support.Viewer(server.port, size=(160, 90)) for _ in range(4)]
    for viewer in viewers:
        viewer.number = 1
    says = [
        lambda v: v.camera(v.number, moving=rng.random() < 0.7),
        lambda v: v.say(type='settings', inputId=v.number, values={'shadows': rng.random() < 0.5, 'maxReflections': rng.randrange(8)}),
        lambda v: v.say(type='settings', inputId=v.number, values={'maxReflections': -1, 'nothing': 'x' * 200}),
        lambda v: v.say(type='resolution', inputId=v.number, width=rng.randrange(64, 320), height=rng.randrange(36, 180)),
        lambda v: v.say(type='focus', inputId=v.number, x=rng.random(), y=rng.random()),
        lambda v: v.say(type='ping', time=1.0),
        lambda v: v.say(type='picture', format='png'),
        lambda v: v.say(type='effectCosts'),
        lambda v: v.say(type='accuracy', seconds=rng.choice((0, 3, 5))),
    ]
    while time.monotonic() - start < options.storm:
        for viewer in viewers:
            for _ in range(4):
                viewer.number += 1
                count += 1
                rng.choice(says)(viewer)
            viewer.read(0.01)
            if viewer.closed:
                raise RuntimeError('a viewer was closed, code %d' % viewer.closed)
            viewer.texts, viewer.inputs = viewer.texts[-1:], viewer.inputs[-1:]
        if not first and time.monotonic() - start > options.storm / 4:
            first = settled(server)
    last = settled(server)
    server.end()
    return flat('%.0f s of messages' % options.storm, first, last, '%d messages' % count)


def soak(options):
    """Twenty viewers who come over five seconds, do all kinds of things for fifteen and go, again and again; odd rounds by video.
    Sizes and what they do differ from round to round."""
    server = support.Server('--max-viewers', '40', '--keep-views', '1', scene='courtyard')
    rng, start, first, memory, rounds = random.Random(1), time.monotonic(), 0.0, [], 0
    while time.monotonic() - start < options.soak or rounds < 2:
        size = rng.choice(('160x90', '320x180', '640x360'))
        script = rng.choice(('orbit', 'path', 'walk', 'settings', 'mixed'))
        load = [LOAD, 'ws://127.0.0.1:%d/ws' % server.port, '--viewers', '20', '--ramp', '5', '--seconds', '15', '--size', size,
                '--script', script, '--seed', str(rounds + 1), '--require', 'errors<=0', '--require', 'refused<=0']
        said = subprocess.run(load + (['--vp9'] if rounds % 2 else []), stdout=subprocess.PIPE, text=True, timeout=120)
        if said.returncode:
            raise RuntimeError('round %d: exit code %d\n%s' % (rounds, said.returncode, said.stdout[-500:]))
        rounds += 1
        nobody(server)
        memory.append(settled(server))
        if not first and time.monotonic() - start > options.soak / 4:
            first = memory[-1]
            print('<!-- MiB after each round so far: %s -->' % ' '.join('%.0f' % m for m in memory), file=sys.stderr, flush=True)
    print('<!-- MiB after each round: %s -->' % ' '.join('%.0f' % m for m in memory), file=sys.stderr, flush=True)
    server.end()
    return flat('%.0f s of twenty viewers who come and go' % options.soak, first, memory[-1], '%d rounds, first %.0f MiB' % (rounds, memory[0]))


def restart(options):
    """Killed, and started again on the same port."""
    port, longest = support.free_port(), 0.0
    server = support.Server(scene='courtyard', port=port)
    for _ in range(5):
        server.end(signal.SIGKILL)
        start = time.monotonic()
        server = support.Server(scene='courtyard', port=port)
        viewer = support.Viewer(port, size=(320, 180))
        viewer.read(20.0, lambda: viewer.inputs)
        longest = max(longest, time.monotonic() - start)
        viewer.socket.close()
    server.end()
    row('killed and started again, courtyard', '', '%.2f s' % longest, 'to the first picture, longest of 5')
    return True


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('--parts', default='idle,viewers,cycles,storm,soak,restart')
    parser.add_argument('--cycles', type=int, default=10000)
    parser.add_argument('--storm', type=float, default=600.0)
    parser.add_argument('--soak', type=float, default=1800.0)
    parser.add_argument('--connections', type=int, default=1000)
    options = parser.parse_args()
    print('| what | before | after | |\n| --- | ---: | ---: | --- |', flush=True)
    good = [globals()[part](options) for part in options.parts.split(',')]
    sys.exit(0 if all(good) else 1)


if __name__ == '__main__':
    main()
