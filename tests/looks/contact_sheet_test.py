#!/usr/bin/env python3
"""What the contact sheet reads of pictures, and what it says of them; the last line is `N passed, N failed`."""
import os, stat, struct, subprocess, sys, tempfile, unittest, zlib

import contact_sheet
from png_pixels import pixels_of

HERE = os.path.dirname(os.path.abspath(__file__))


def filtered(kind, row, above, channels):
    """A row as an encoder would store it, by the specification's own words."""
    def paeth(a, b, c):
        p = a + b - c
        pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
        return a if pa <= pb and pa <= pc else b if pb <= pc else c
    stored = bytearray([kind])
    for i, value in enumerate(row):
        a = row[i - channels] if i >= channels else 0
        b, c = above[i], above[i - channels] if i >= channels else 0
        stored.append((value - (0, a, b, (a + b) // 2, paeth(a, b, c))[kind]) & 255)
    return bytes(stored)


def png(width, height, at, channels=3, kinds=(0,)):
    rows = [bytes(v for x in range(width) for v in at(x, y)) for y in range(height)]
    raw = b''.join(filtered(kinds[y % len(kinds)], row, rows[y - 1] if y else bytes(len(row)), channels)
                   for y, row in enumerate(rows))
    chunk = lambda name, body: struct.pack('>I', len(body)) + name + body + struct.pack('>I', zlib.crc32(name + body))
    header = struct.pack('>IIBBBBB', width, height, 8, 2 if channels == 3 else 6, 0, 0, 0)
    return b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', header) + chunk(b'IDAT', zlib.compress(raw)) + chunk(b'IEND', b'')


def disc(inside, radius=20, size=64, backdrop=118):
    """A picture of a disc in the middle; `inside` (x, y) is its grey."""
    def at(x, y):
        near = (x - size / 2) ** 2 + (y - size / 2) ** 2 < radius ** 2
        return (inside(x, y) if near else backdrop,) * 3
    return png(size, size, at)


class Pixels(unittest.TestCase):
    def test_every_filter_gives_the_same_pixels(self):
        at = lambda x, y: ((37 * x + 11 * y) % 256, (x * y) % 256, (255 - 5 * x) % 256)
        plain = pixels_of(png(23, 17, at))
        self.assertEqual(plain[2][16][3 * 22:], bytes(at(22, 16)))
        for kinds in [(1,), (2,), (3,), (4,), (0, 1, 2, 3, 4)]:
            self.assertEqual(pixels_of(png(23, 17, at, kinds=kinds)), plain, kinds)

    def test_alpha_is_left_out(self):
        rgb = lambda x, y: (x, y, 200)
        self.assertEqual(pixels_of(png(9, 7, lambda x, y: (*rgb(x, y), 3 * x), 4, (4,))), pixels_of(png(9, 7, rgb)))

    def test_what_is_no_such_png_is_refused(self):
        for data in (b'', b'P6 1 1 255', png(2, 2, lambda x, y: (0, 0, 0)).replace(b'\x08\x02', b'\x10\x02')):
            self.assertRaises(ValueError, pixels_of, data)


class Words(unittest.TestCase):
    def words(self, picture):
        return contact_sheet.words_of(contact_sheet.figures_of(picture))

    def test_a_shaded_disc_needs_none(self):
        picture = disc(lambda x, y: 130 + x)
        self.assertEqual(self.words(picture), [])
        self.assertAlmostEqual(contact_sheet.figures_of(picture)['share'], 3.14159 * 400 / 4096, delta=0.01)

    def test_each_has_its_word(self):
        self.assertEqual(self.words(disc(lambda x, y: 118)), ['empty'])
        self.assertEqual(self.words(disc(lambda x, y: 200)), ['flat'])
        self.assertEqual(self.words(disc(lambda x, y: 3 if x % 3 else 220)), ['black'])
        self.assertEqual(self.words(disc(lambda x, y: 255 if x % 9 == 0 else 90)), ['burnt'])
        self.assertEqual(self.words(disc(lambda x, y: 40 + 3 * x, 36)), ['cut'])

    def test_apart(self):
        dark, light = disc(lambda x, y: 50), disc(lambda x, y: 60)
        self.assertEqual(contact_sheet.apart(dark, dark), 0)
        self.assertAlmostEqual(contact_sheet.apart(dark, light), 10 * 3.14159 * 400 / 4096, delta=0.1)
        self.assertIsNone(contact_sheet.apart(dark, disc(lambda x, y: 50, size=32)))


class Sheet(unittest.TestCase):
    def test_programs_stand_beside_each_other_and_refusals_are_told(self):
        with tempfile.TemporaryDirectory() as folder:
            path = lambda name: os.path.join(folder, name)
            for name, grey in (('first', 60), ('second', 90)):
                with open(path(name + '.png'), 'wb') as file:
                    file.write(disc(lambda x, y: grey + x))
                with open(path(name), 'w') as file:  # render MODEL --out FILE
                    file.write(f'#!/bin/sh\ncase $2 in *bad*) echo "heliograph: $2: <no> mesh" >&2; exit 2 ;; esac\n'
                               f'cp {path(name)}.png "$4"\n')
                os.chmod(path(name), stat.S_IRWXU)
            command = [sys.executable, os.path.join(HERE, 'contact_sheet.py'), 'good.glb', 'bad.glb', '--program', path('first'),
                       '--against', path('second'), '--out', path('sheet.html')]
            done = subprocess.run(command, capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn('2 models, 1 with a word', done.stdout)
            with open(path('sheet.html'), encoding='utf-8') as file:
                sheet = file.read()
            self.assertEqual(sheet.count('<img'), 2)
            self.assertIn('&lt;no&gt; mesh', sheet)
            self.assertRegex(sheet, r'good.*against: .*; 9\.\d codes apart')


if __name__ == '__main__':
    ran = unittest.main(exit=False).result
    failed = len(ran.failures) + len(ran.errors)
    print(f'{ran.testsRun - failed} passed, {failed} failed')
    sys.exit(failed > 0)
