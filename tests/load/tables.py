#!/usr/bin/env python3
"""The tables of docs/measurements/load.md: heliograph-load with 1, 10, 50 and 200 viewers, and with every kind of line, against
a server of its own for each row.

tables.py [--seconds 10] [--scene cornell] [--size 320x180] [--viewers 1,10,50,200] [--html FILE]; prints Markdown. HELIOGRAPH
and HELIOGRAPH_LOAD name the programs."""
import argparse, json, os, subprocess, sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'operations'))
import support

LOAD = os.environ.get('HELIOGRAPH_LOAD', os.path.join(support.ROOT, 'build/release/tests/heliograph-load'))
LINES = ['none', 'slow', 'latency', 'lossy', 'stalls', 'close']


def resident(pid):
    with open('/proc/%d/status' % pid) as f:
        return next(int(line.split()[1]) for line in f if line.startswith('VmHWM:')) / 1024


def measured(options, viewers, network='none', more=()):
    server = support.Server('--max-viewers', '1000', scene=options.scene)
    before = resident(server.process.pid)
    ramp = max(1.0, viewers / 20)
    run = subprocess.run([LOAD, 'ws://127.0.0.1:%d/ws' % server.port, '--viewers', str(viewers), '--seconds', str(options.seconds),
                          '--ramp', str(ramp), '--size', options.size, '--script', 'walk', '--network', network, '--json', *more],
                         stdout=subprocess.PIPE, text=True)
    report = json.loads(run.stdout)
    memory = (resident(server.process.pid) - before) / viewers
    code, _ = server.end()
    return report, memory, code


def row(label, result):
    report, memory, code = result
    rate, photon = report['fps_per_viewer'], report['motion_to_photon_ms']
    print('| %s | %d | %.0f | %.2f | %.2f | %.0f | %.0f | %.0f | %d | %d | %.1f |%s' % (
        label, report['admitted'], report['frames'] / report['seconds'], rate['mean'], rate['min'], photon['p50'], photon['p95'],
        report['last_input_ms'], report['errors'], report['refused'], memory, '' if code == 0 else ' exit code %d' % code),
        flush=True)


def head(first):
    print('\n| %s | inside | frames/s | mean | least | p50 | p95 | last | errors | refused | MiB |' % first)
    print('| ---: | ' + ' | '.join(['---:'] * 10) + ' |', flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('--seconds', type=float, default=10.0)
    parser.add_argument('--scene', default='cornell')
    parser.add_argument('--size', default='320x180')
    parser.add_argument('--viewers', default='1,10,50,200')
    parser.add_argument('--html', default='')
    options = parser.parse_args()
    counts = [int(text) for text in options.viewers.split(',')]
    head('viewers')
    for viewers in counts:
        html = ('--html', options.html) if options.html and viewers == counts[-1] else ()
        row(viewers, measured(options, viewers, more=html))
    head('line, 10 viewers')
    for network in LINES:
        row(network, measured(options, 10, network))


if __name__ == '__main__':
    main()
