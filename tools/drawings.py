#!/usr/bin/env python3
"""Makes the drawings of docs/images: tools/drawings.py [FOLDER]. Dark on light, no library."""

import sys
from pathlib import Path
from xml.sax.saxutils import escape

INK, MUTED, LINE = '#1b1f24', '#5b6470', '#8a94a0'
PLAIN, BLUE, RED, GREEN, YELLOW = '#f3f5f8', '#dbe8fb', '#fbdfd6', '#dcf0e0', '#fbf0cf'


class Drawing:
    def __init__(self, width, height, title):
        self.size, self.title, self.parts = (width, height), title, []
        self.text(24, 34, title, size=19, bold=True)

    def text(self, x, y, words, size=13, bold=False, colour=INK, anchor='start'):
        weight = ' font-weight="600"' if bold else ''
        self.parts.append(f'<text x="{x}" y="{y}" font-size="{size}"{weight} fill="{colour}" '
                          f'text-anchor="{anchor}">{escape(words)}</text>')

    def rect(self, x, y, width, height, fill=PLAIN, dashed=False, radius=6):
        dash = ' stroke-dasharray="5 4"' if dashed else ''
        self.parts.append(f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="{radius}" '
                          f'fill="{fill}" stroke="{LINE}"{dash}/>')

    def box(self, x, y, width, height, name, *lines, fill=PLAIN, dashed=False):
        """A box with a bold name and smaller lines, centred."""
        self.rect(x, y, width, height, fill, dashed)
        top = y + height / 2 - 8.5 * len(lines) + 5
        self.text(x + width / 2, top, name, 14, True, anchor='middle')
        for i, line in enumerate(lines):
            self.text(x + width / 2, top + 17 * (i + 1), line, 12, colour=MUTED, anchor='middle')

    def arrow(self, *points, dashed=False, words='', at=None, anchor='middle'):
        dash = ' stroke-dasharray="5 4"' if dashed else ''
        path = ' '.join(f'{x},{y}' for x, y in points)
        self.parts.append(f'<polyline points="{path}" fill="none" stroke="{INK}" stroke-width="1.4" '
                          f'marker-end="url(#head)"{dash}/>')
        if words:
            x, y = at or ((points[0][0] + points[-1][0]) / 2, (points[0][1] + points[-1][1]) / 2 - 6)
            self.text(x, y, words, 12, colour=MUTED, anchor=anchor)

    def line(self, x0, y0, x1, y1, dashed=False):
        dash = ' stroke-dasharray="5 4"' if dashed else ''
        self.parts.append(f'<line x1="{x0}" y1="{y0}" x2="{x1}" y2="{y1}" stroke="{LINE}"{dash}/>')

    def write(self, path):
        width, height = self.size
        path.write_text(
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
            f'height="{height}" font-family="system-ui, \'Noto Sans\', \'DejaVu Sans\', sans-serif">\n'
            f'<title>{escape(self.title)}</title>\n'
            '<defs><marker id="head" markerWidth="9" markerHeight="8" refX="8" refY="4" orient="auto">'
            f'<path d="M0,0 L9,4 L0,8 z" fill="{INK}"/></marker></defs>\n'
            f'<rect width="{width}" height="{height}" fill="#ffffff"/>\n' + '\n'.join(self.parts) + '\n</svg>\n')


def rooms():
    d = Drawing(960, 824, 'Rooms: each may include what stands below it')
    step, top = 62, 56

    def row(i):
        return top + i * step

    tower = [('stream', 'views, and who looks at them'), ('viewer', 'what one viewer is sent'),
             ('loop', 'what a view renders next'),
             ('render', 'does it: turns, threads, passes'), ('schedule', 'who renders what; pure'),
             ('device', 'the contract of every device'),
             ('film', 'what is known of the picture'), ('request', 'what is asked; values'),
             ('scene', 'what is looked at; immutable'), ('kernel', 'C++ side of the shading source')]
    d.box(24, row(0), 912, 48, 'app', 'commands; the only room that names concrete devices', fill=YELLOW)
    for i, (name, words) in enumerate(tower):
        d.box(330, row(i + 1), 300, 48, name, words, fill=BLUE)
        d.arrow((480, row(i) + 48), (480, row(i + 1)))
    d.box(24, row(11), 912, 48, 'base', 'errors, log, clock, mailbox, progress, words', fill=YELLOW)
    d.arrow((480, row(10) + 48), (480, row(11)))

    d.box(676, row(1), 260, 48, 'operations', 'configuration, metrics, service manager')
    d.box(676, row(4), 260, 48, 'lab', 'benchmarks, the simulator')
    for i in (1, 4):
        d.arrow((676, row(i) + 24), (630, row(i) + 24))
    d.box(676, row(5), 260, 48, 'device/embree', 'the processor, by Embree', fill=RED)
    d.box(676, row(6), 260, 48, 'device/vulkan', 'core, tree, trace, raster, bench', fill=RED)
    d.arrow((676, row(5) + 24), (654, row(5) + 24), (654, row(6) + 14), (630, row(6) + 14))
    d.arrow((676, row(6) + 24), (630, row(6) + 24))
    d.box(676, row(9), 260, 48, 'scene/{build,load,generate}', 'files and recipes become a scene', fill=GREEN)
    d.arrow((676, row(9) + 24), (630, row(9) + 24))

    d.box(24, row(1), 260, 48, 'client-web', 'the page, in the browser', dashed=True)
    d.box(24, row(3), 260, 48, 'net', 'messages; net/web: sockets and HTTP', fill=GREEN)
    d.arrow((330, row(2) + 36), (308, row(2) + 36), (308, row(3) + 14), (284, row(3) + 14))
    d.arrow((154, row(1) + 48), (154, row(3)), dashed=True, words='WebSocket', at=(166, row(2) + 4), anchor='start')
    d.arrow((284, row(3) + 36), (308, row(3) + 36), (308, row(8) + 24), (330, row(8) + 24))
    d.box(24, row(5), 260, 48, 'encode', 'pixels to bytes', fill=GREEN)
    d.arrow((330, row(2) + 42), (296, row(2) + 42), (296, row(5) + 24), (284, row(5) + 24))
    d.box(24, row(6), 260, 48, 'images', 'reads pictures; door to OpenImageIO', fill=GREEN)
    d.arrow((154, row(5) + 48), (154, row(6)))
    d.box(24, row(10), 260, 48, 'shaders/kernel', 'every colour, written once', fill=YELLOW)
    d.arrow((330, row(10) + 24), (284, row(10) + 24))
    d.text(24, 816, 'Not drawn: what follows from these. tests/check_includes.sh holds the whole table.', 12, colour=MUTED)
    return d


def frame():
    d = Drawing(960, 590, 'A frame over its threads')
    lanes = [('Browser', 'the page'), ('Socket thread', 'one for all viewers'), ('View thread', 'one a view'),
             ('Device threads', 'workers, GPU streams'), ('Encode thread', 'one a viewer')]
    for i, (name, words) in enumerate(lanes):
        y = 60 + 100 * i
        d.rect(24, y, 912, 88, '#fafbfc')
        d.text(36, y + 38, name, 14, True)
        d.text(36, y + 56, words, 12, colour=MUTED)

    def at(x, lane, width, name, *lines, fill=PLAIN):
        d.box(x, 68 + 100 * lane, width, 72, name, *lines, fill=fill)

    def y(lane):
        return 68 + 100 * lane

    at(176, 0, 96, 'input', 'camera 17')
    at(176, 1, 96, 'check', 'newest wins')
    at(176, 2, 96, 'decide', 'finish, give', 'up, begin')
    at(292, 2, 76, 'turn', 'fair share')
    at(318, 3, 130, 'trace tiles', 'kernel stages,', 'any order', fill=BLUE)
    at(408, 2, 96, 'film', 'continues?', 'else refused', fill=GREEN)
    at(524, 2, 92, 'due?', 'credit left?')
    at(548, 4, 156, 'develop, encode', 'tone, sRGB, JPEG', fill=YELLOW)
    at(636, 2, 132, 'next pass', 'meanwhile')
    at(636, 3, 132, 'trace tiles', fill=BLUE)
    at(708, 1, 88, 'write', 'header, bytes')
    at(796, 0, 128, 'decode, draw', 'measure latency')
    at(836, 1, 88, 'credit', 'frame done')
    d.arrow((224, y(0) + 72), (224, y(1)))
    d.arrow((224, y(1) + 72), (224, y(2)), words='one slot', at=(230, y(2) - 9), anchor='start')
    d.arrow((272, y(2) + 36), (292, y(2) + 36))
    d.arrow((345, y(2) + 72), (345, y(3)))
    d.arrow((430, y(3)), (430, y(2) + 72))
    d.arrow((504, y(2) + 36), (524, y(2) + 36))
    d.arrow((616, y(2) + 36), (636, y(2) + 36))
    d.arrow((578, y(2) + 72), (578, y(4)), words='one slot', at=(584, y(4) - 36), anchor='start')
    d.arrow((700, y(2) + 72), (700, y(3)))
    d.arrow((704, y(4) + 36), (784, y(4) + 36), (784, y(1) + 72), words='one slot', at=(790, y(4) + 12), anchor='start')
    d.arrow((760, y(1)), (760, y(0) + 50), (796, y(0) + 50))
    d.arrow((880, y(0) + 72), (880, y(1)), words='ack', at=(886, y(1) - 9), anchor='start')
    d.text(24, 582, 'Time runs to the right. Where two threads run at different speeds there is one slot: the newest '
           'replaces the one that waits.', 12, colour=MUTED)
    return d


def kernel():
    d = Drawing(960, 520, 'The kernel and its three compilers')
    d.box(24, 200, 210, 120, 'shaders/kernel', 'stages as functions,', 'tables of effects and settings,', 'own sin, exp, log, pow', fill=YELLOW)
    rows = [('g++ on lanes', ('kernel_lanes.h: a float is', '16, 8 or 4 values'), 'tile programs',
             ('x86-64-v2, v3, v4', 'five sets of effects'), 'Embree driver', ('queues of rays, packets;', 'stages a block at a time'), BLUE),
            ('g++ scalar', ('kernel.h: inside', 'struct Kernel<EFFECTS>'), 'scalar kernel', ('one point at a time',),
             'filters and tests', ('cut-outs, shadows through', 'glass, the unit tests'), GREEN),
            ('glslang', ('trace.comp; SPIR-V marked', 'NoContraction'), 'pipelines',
             ('specialised for exactly', 'the request\u2019s effects'), 'Vulkan driver', ('one path a pixel,', 'trees of its own'), RED)]
    for i, (compiler, how, made, which, user, does, fill) in enumerate(rows):
        y = 70 + 140 * i
        d.box(290, y, 190, 100, compiler, *how)
        d.box(520, y, 180, 100, made, *which, fill=fill)
        d.box(740, y, 196, 100, user, *does, fill=fill)
        d.arrow((234, 260), (262, 260), (262, y + 50), (290, y + 50))
        d.arrow((480, y + 50), (520, y + 50))
        d.arrow((700, y + 50), (740, y + 50))
    d.text(24, 494, 'No fused multiply-add, no library transcendental, contributions summed in one order: '
           'the same triangle gives the same bits.', 12, colour=MUTED)
    d.text(24, 512, './check parity compares the pictures, ./check isa the instructions.', 12, colour=MUTED)
    return d


def hybrid():
    d = Drawing(960, 440, 'A hybrid frame: who works when')
    left, right, end = 170, 900, 812
    names = ['GPU, stream 1', 'GPU, stream 2', 'core 1', 'core 2', 'core 3']
    rows = {name: 72 + 56 * i for i, name in enumerate(names)}
    for name, y in rows.items():
        d.text(24, y + 24, name, 13, True)
        d.line(left, y + 38, right, y + 38)

    def work(name, fill, *spans):
        for begin, stop, words in spans:
            d.rect(begin, rows[name], stop - begin, 36, fill, radius=3)
            d.text((begin + stop) / 2, rows[name] + 23, words, 12, anchor='middle')

    work('GPU, stream 1', RED, (170, 400, 'batch 1: 420 cells'), (560, 700, '3: 230'), (778, 810, '5'))
    work('GPU, stream 2', RED, (400, 556, '2: 310 cells'), (700, 776, '4: 120'))
    work('core 1', BLUE, (170, 420, '24 cells'), (422, 590, '15'), (592, 702, '9'), (704, 768, '5'), (770, 806, '2'))
    work('core 2', BLUE, (170, 432, '24 cells'), (434, 596, '15'), (598, 716, '9'), (718, 776, '4'), (778, 804, '1'))
    work('core 3', BLUE, (170, 440, '24 cells'))
    d.rect(442, rows['core 3'], 250, 36, '#ffffff', dashed=True, radius=3)
    d.text(567, rows['core 3'] + 23, 'overdue: stalls', 12, colour=MUTED, anchor='middle')
    for name, begin in (('GPU, stream 1', 400), ('GPU, stream 2', 556), ('GPU, stream 1', 700)):
        work(name, GREEN, (begin, begin + 56, 'to film'))
    d.arrow((692, rows['core 3']), (745, rows['core 1'] + 37), words='given out again', at=(742, rows['core 3'] + 6), anchor='start')
    d.line(end, 62, end, 372, dashed=True)
    d.text(end, 390, 'end of the frame', 12, anchor='middle')
    d.arrow((170, 372), (930, 372), words='time', at=(916, 366))
    d.text(24, 410, 'A batch is a fair share of what is left, less what predictions may be wrong by: so batches shrink. '
           'None starts that would end', 12, colour=MUTED)
    d.text(24, 428, 'after the rest of the frame. Whichever result of a cell comes first counts; the film refuses the other.',
           12, colour=MUTED)
    return d


def faults():
    d = Drawing(960, 610, 'Where each kind of fault is caught')
    for x, words in ((24, 'what goes wrong'), (330, 'where it is caught'), (636, 'what happens then')):
        d.text(x, 62, words, 13, True, MUTED)
    rows = [('a message breaks the rules', ('wrong type, range, size',), 'net: parser, field by field', ('InputError names the field',),
             'error to that viewer', ('nothing else changes',), BLUE),
            ('a file is wrong', ('reference, size, type',), 'scene/load, scene/build', ('before memory is taken',),
             'file refused, or a warning', ('where the loss can be seen',), GREEN),
            ('a device throws or is lost', ('driver, memory',), 'render: around every call', ('once a worker',),
             'set aside, with a notice', ('others make its cells',), RED),
            ('a device stalls', ('no answer in time',), 'schedule: overdue', ('a pure rule on the clock',),
             'its cells are given out again', ('it sits out until it answers',), RED),
            ('a result is late or double', ('stale generation, twice',), 'film: must continue its cell', ('generation, next sample',),
             'refused without harm', ('the first one counted',), YELLOW),
            ('a sample is not finite', ('NaN, infinity',), 'device: when a sample ends', ('never clamped away',),
             'left out and counted', ('nonfiniteSamples',), YELLOW),
            ('a viewer is slow or gone', ('no ack, no pong',), 'stream, net: credit, limits', ('2 frames, 10 s, 30 s',),
             'frames dropped, then closed', ('others do not notice',), BLUE)]
    for i, (what, more, where, how, then, so, fill) in enumerate(rows):
        y = 74 + 74 * i
        d.box(24, y, 270, 60, what, *more)
        d.box(330, y, 270, 60, where, *how, fill=fill)
        d.box(636, y, 300, 60, then, *so)
        d.arrow((294, y + 30), (330, y + 30))
        d.arrow((600, y + 30), (636, y + 30))
    d.text(24, 602, './check fuzz, asan, tsan and the hard cases of ./check unit look for what nobody catches.', 12, colour=MUTED)
    return d


if __name__ == '__main__':
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent / 'docs/images')
    for make in (rooms, frame, kernel, hybrid, faults):
        make().write(folder / f'{make.__name__}.svg')
