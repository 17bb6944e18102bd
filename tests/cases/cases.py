#!/usr/bin/env python3
"""Kinds of file that other programs were reported to draw wrong, each made here and drawn on each device: what must be seen is
known. Prints a row per question; the last line is `N passed, N failed`.

cases.py [--program build/release/heliograph] [--devices embree,vulkan] [NAME...]"""
import argparse, json, math, os, subprocess, sys, tempfile
from concurrent.futures import ThreadPoolExecutor

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import far_cases, gltf_cases, obj_cases, picture_cases
from files import Gltf, SQUARE, SQUARE_INDICES, SQUARE_UV, at, data, deviation, film, mean, png, rgbe

GREEN = png(2, 2, lambda x, y: (0, 255, 0))


class Case:
    def __init__(self, name, folder):
        self.name, self.folder, self.questions = name, folder, []

    def path(self, name):
        path = os.path.join(self.folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        return path

    def write(self, name, content):
        with open(self.path(name), 'wb') as file:
            file.write(content if isinstance(content, bytes) else content.encode())
        return self.path(name)

    def ask(self, what, file, measure, expected, tolerance=0.01, warns=None, options=()):
        """`measure` of the film of `file` must be `expected`; a function: of the film of another file, given by name."""
        self.questions.append((what, file, measure, expected, tolerance, warns, tuple(options)))


    def alike(self, file, share=.995):
        """Of the pixels that the devices make of `file`, at least that share is the same bit by bit."""
        self.questions.append(('the same on every device', file, None, (share,), 0, None, ()))


def unlit_square(case, name, colors=None, uri=None, component=5126):
    scene = Gltf()
    attributes, material = {}, scene.unlit()
    if colors:
        attributes['COLOR_0'] = scene.accessor(colors, component, **({} if component == 5126 else {'normalized': True}))
    if uri:
        scene.add('images', {'uri': uri})
        scene.add('textures', {'source': 0})
        scene.root['materials'][material]['pbrMetallicRoughness'] = {'baseColorTexture': {'index': 0}}
        attributes['TEXCOORD_0'] = scene.accessor(SQUARE_UV)
    scene.node(mesh=scene.mesh(SQUARE, SQUARE_INDICES, material, **attributes))
    scene.camera((0, 0, 1))
    scene.save(case.path(name))
    return case.path(name)


def centre(rows):
    return at(rows, .5, .5)


OBJ_QUAD = 'v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n'


def obj_polygons(case):
    arrow = 'v -1 -1 0\nv 0 -0.2 0\nv 1 -1 0\nv 0 1 0\n'
    case.write('m.mtl', 'newmtl m\nKe 1 1 1\nKd 0 0 0\n')
    whole = case.write('face.obj', 'mtllib m.mtl\n' + arrow + 'usemtl m\nf 1 2 3 4\n')
    parts = case.write('parts.obj', 'mtllib m.mtl\n' + arrow + 'usemtl m\nf 1 2 4\nf 2 3 4\n')
    case.ask('a concave face is its triangles', whole, mean, parts, 1e-4)
    case.ask('a line that goes on', case.write('on.obj', 'mtllib m.mtl\n' + arrow + 'usemtl m\nf 1 2 \\\n 3 4\n'), mean, parts, 1e-4)
    case.ask('a byte order mark', case.write('bom.obj', '\ufeffmtllib m.mtl\n' + arrow + 'usemtl m\nf 1 2 3 4\n'), mean, parts, 1e-4)


def obj_materials(case):
    case.write('two words.mtl', 'newmtl a red one\nKd 0 0 0\nKe 1 0 0\nnewmtl other\nKd 0 0 0\nnewmtl picture\nmap_Kd green.png\n')
    case.write('green.png', GREEN)
    face = 'f 1/1 2/2 3/3 4/4\n'
    case.ask('blanks in names', case.write('blanks.obj', 'mtllib two words.mtl\n' + OBJ_QUAD + 'usemtl a red one\n' + face), centre, (1, 0, 0))
    case.ask('a map after another material with Kd is not black',
             case.write('map.obj', 'mtllib two words.mtl\n' + OBJ_QUAD + 'usemtl picture\n' + face), lambda f: [min(centre(f)[1] * 100, 1)], (1,))
    for name, line in (('absolute', '/etc/hostname'), ('climbing', '../outside.png')):
        case.write(name + '.mtl', f'newmtl m\nKd 0 0 0\nKe 1 1 1\nmap_Ke {line}\n')
        case.ask(name + ' path of a picture', case.write(name + '.obj', f'mtllib {name}.mtl\n' + OBJ_QUAD + 'usemtl m\n' + face), centre,
                 (1, 1, 1), warns=line)


def gltf_pictures(case):
    for name, uri in (('missing', 'gone.png'), ('absolute', '/etc/hostname'), ('climbing', '../outside.png'), ('web', 'http://example.org/a.png')):
        case.ask(name + ' picture: drawn without, told', unlit_square(case, name + '.gltf', uri=uri), centre, (1, 1, 1), warns=uri)
    case.ask('a picture inside', unlit_square(case, 'inside.gltf', uri=data('image/png', GREEN)), centre, (0, 1, 0))


def vertex_colours(case):
    for level in (0.0015, 0.0025, 0.006):
        case.ask(f'float colour {level}', unlit_square(case, f'{level}.gltf', [(level,) * 3] * 4), centre, (level,) * 3, 2e-5)
        word = round(level * 65535)
        case.ask(f'16-bit colour {word}', unlit_square(case, f'{word}-16.gltf', [(word,) * 4] * 4, component=5123), centre, (word / 65535,) * 3, 2e-5)
    case.ask('8-bit colour 128', unlit_square(case, '8.gltf', [(128, 64, 0, 255)] * 4, component=5121), centre, (128 / 255, 64 / 255, 0), 1e-4)


def second_coordinates(case):
    checker = data('image/png', png(64, 64, lambda x, y: (255,) * 3 if (x // 8 + y // 8) % 2 else (0,) * 3))
    for tiled in (1, 20, 200):
        scene = Gltf()
        scene.add('images', {'uri': checker})
        scene.add('textures', {'source': 0})
        material = scene.unlit(baseColorTexture={'index': 0, 'texCoord': 1})
        first = scene.accessor([(u * tiled, v * tiled) for u, v in SQUARE_UV])
        scene.node(mesh=scene.mesh(SQUARE, SQUARE_INDICES, material, TEXCOORD_0=first, TEXCOORD_1=scene.accessor(SQUARE_UV)))
        scene.camera((0, 0, 1))
        scene.save(case.path(f'{tiled}.gltf'))
        if tiled > 1:
            case.ask(f'sharp on the second set, the first tiled {tiled} times', case.path(f'{tiled}.gltf'), lambda f: [deviation(f)],
                     case.path('1.gltf'), 1e-3)


def sky(case):
    """Thirds from the top: red 2, green 1, blue 0.5; a white column at u = 0.75."""
    width, height = 32, 18

    def color(x, y):
        if 22 <= x < 26 and 6 <= y < 12:
            return 4, 4, 4
        return ((2, 0, 0), (0, 1, 0), (0, 0, .5))[y // 6]

    scene = Gltf()
    scene.node(mesh=scene.mesh([(x * .001, y * .001, z - 1000) for x, y, z in SQUARE], SQUARE_INDICES, scene.unlit()))
    scene.light([0, 0, 0], [0, 0, 0, 1], type='point', intensity=0)
    half = math.sqrt(.5)
    for name, rotation in (('up', (half, 0, 0, half)), ('right', (0, -half, 0, half))):
        scene.camera((0, 0, 0), 17, rotation, name)
    scene.save(case.path('sky.gltf'))

    def stored(y, x, columns, scale=1, variables=''):
        turned = lambda i, j: color(width - 1 - i if x == '-X' else i, height - 1 - j if y == '+Y' else j)
        order = [(i, j) for i in range(width) for j in range(height)] if columns else [(i, j) for j in range(height) for i in range(width)]
        sizes = f'{x} {width} {y} {height}' if columns else f'{y} {height} {x} {width}'
        return (f'#?RADIANCE\n{variables}FORMAT=32-bit_rle_rgbe\n\n{sizes}\n').encode() + b''.join(
            rgbe([v * scale for v in turned(i, j)]) for i, j in order)

    kinds = {'-Y +X': stored('-Y', '+X', False), '+Y +X': stored('+Y', '+X', False), '-Y -X': stored('-Y', '-X', False),
             '+X -Y': stored('-Y', '+X', True), '-X +Y': stored('+Y', '-X', True),
             'EXPOSURE': stored('-Y', '+X', False, 2, 'EXPOSURE=2\n')}
    for name, content in kinds.items():
        file = case.write(name.replace(' ', '') + '.hdr', content)
        for view, expected in (('up', (2, 0, 0)), ('right', (4, 4, 4))):
            case.ask(f'{name}: {view}', case.path('sky.gltf'), centre, expected, options=('--environment', file, '--camera', view))


def narrow_spots(case):
    """The middle of a cone on a white floor 2 m below is as bright however narrow the cone is."""
    half = math.sqrt(.5)
    for degrees in (20, 0.5, 0.1):
        scene = Gltf()
        material = scene.add('materials', {'pbrMetallicRoughness': {'baseColorFactor': [1, 1, 1, 1], 'metallicFactor': 0, 'roughnessFactor': 1}})
        size = 2 * math.tan(math.radians(degrees)) * .1
        scene.node(mesh=scene.mesh([(x * size, y * size, 0) for x, y, z in SQUARE], SQUARE_INDICES, material))
        scene.light([0, 0, 2], [0, 0, 0, 1], type='spot', intensity=4, spot={'outerConeAngle': math.radians(degrees)})
        scene.camera((0, 0, size * 4), 10)
        scene.save(case.path(f'{degrees}.gltf'))
        if degrees < 20:
            case.ask(f'the middle of a cone of {degrees} degrees', case.path(f'{degrees}.gltf'), centre, case.path('20.gltf'))


def specular_colours(case):
    """A smooth black floor seen under cosine 0.1, in surroundings of red 0.24: Schlick's curve from the factor times 0.04 times
    the colour straight on to the factor at grazing."""
    for factor, colour in ((1, 1), (1, 0), (1, .25), (.5, 1), (.5, 0), (0, 1)):
        scene = Gltf()
        material = scene.add('materials', {
            'pbrMetallicRoughness': {'baseColorFactor': [0, 0, 0, 1], 'metallicFactor': 0, 'roughnessFactor': 0},
            'extensions': {'KHR_materials_specular': {'specularFactor': factor, 'specularColorFactor': [colour] * 3}}})
        scene.uses('KHR_materials_specular')
        lean = math.acos(.1) / 2
        floor = scene.mesh([(x * 50, y * 50, 0) for x, y, z in SQUARE], SQUARE_INDICES, material)
        scene.node(mesh=floor, rotation=[-math.sin(lean), 0, 0, math.cos(lean)])
        scene.light([0, 0, 0], [0, 0, 0, 1], type='point', intensity=0)
        scene.camera((0, 0, 5), 1)
        scene.save(case.path(f'{factor}-{colour}.gltf'))
        straight = .04 * colour
        case.ask(f'specular factor {factor}, colour {colour}, seen flat', case.path(f'{factor}-{colour}.gltf'), lambda f: centre(f)[:1],
                 (.24 * factor * (straight + (1 - straight) * .9 ** 5),), .003)


def rough_panes(case):
    """A thin pane of roughness 0.7 before stripes: it blurs them, and at an index of 1, where there is no interface, it does not."""
    for name, roughness, index in (('clear', 0, 1.0), ('rough', .7, 1.0), ('blurs', .7, 1.5)):
        scene = Gltf()
        for stripe in range(-8, 8):
            colour = [stripe % 2, stripe % 2, stripe % 2, 1]
            scene.node(mesh=scene.mesh([(stripe * .25 + (x + 1) * .125, y * 3, -1) for x, y, z in SQUARE], SQUARE_INDICES,
                                       scene.unlit(baseColorFactor=colour)))
        for extension in ('transmission', 'ior'):
            scene.uses('KHR_materials_' + extension)
        pane = scene.add('materials', {
            'pbrMetallicRoughness': {'metallicFactor': 0, 'roughnessFactor': roughness},
            'extensions': {'KHR_materials_transmission': {'transmissionFactor': 1}, 'KHR_materials_ior': {'ior': index}}})
        scene.node(mesh=scene.mesh(SQUARE, SQUARE_INDICES, pane))
        scene.light([0, 0, 0], [0, 0, 0, 1], type='point', intensity=0)
        scene.camera((0, 0, 3), 20)
        scene.save(case.path(name + '.gltf'))
    case.ask('rough with index 1: sharp', case.path('rough.gltf'), lambda f: [deviation(f)], case.path('clear.gltf'), .01)
    case.ask('rough with index 1.5: blurred', case.path('blurs.gltf'), lambda f: [deviation(f) < .25], (True,))


CASES = [specular_colours, rough_panes, obj_polygons, obj_materials, gltf_pictures, vertex_colours, second_coordinates, sky, narrow_spots,
         *obj_cases.CASES, *gltf_cases.CASES, *picture_cases.CASES,
         *far_cases.CASES]
# What they ask is settled before a device sees the scene: the first one draws them.
READING = {*obj_cases.CASES, *picture_cases.CASES, gltf_cases.names_and_data, gltf_cases.containers}


class Runner:
    def __init__(self, program, folder):
        self.program, self.folder, self.films, self.passed, self.failed = program, folder, {}, 0, 0
        self.drawers = ThreadPoolExecutor(os.cpu_count())

    def begin(self, device, file, options):
        """Draws it beside what else is drawn."""
        key = (device, file, options)
        if key not in self.films:
            self.films[key] = self.drawers.submit(self.draw, len(self.films), *key)
        return self.films[key]

    def draw(self, number, device, file, options):
        out = os.path.join(self.folder, f'film{number}.exr')
        command = [self.program, 'render', file, '--out', out, '--size', '64x64', '--samples', '16', '--device', device, *options]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300, env={**os.environ, 'HELIOGRAPH_CACHE': self.folder})
        rows = film(out) if done.returncode == 0 else None
        if rows is not None:
            os.remove(out)
        return rows, done.stderr

    def film(self, device, file, options):
        return self.begin(device, file, options).result()

    def answer(self, device, question, devices):
        """What was seen, as text, and whether it is right."""
        what, file, measure, expected, tolerance, warns, options = question
        rows, said = self.film(device, file, options)
        if measure is None:
            other, _ = self.film(devices[0], file, options)
            pairs = [a == b for row, against in zip(rows or [], other or []) for a, b in zip(row, against)]
            share = sum(pairs) / len(pairs) if pairs else 0
            return '%.4f' % share, share >= expected[0]
        if rows is None:
            return said.strip().splitlines()[-1][:60] if said.strip() else 'no film', False
        if isinstance(expected, str):
            other, _ = self.film(device, expected, options)
            expected = measure(other)
        seen = measure(rows)
        right = all(abs(a - b) <= tolerance for a, b in zip(seen, expected)) and (not warns or warns in said)
        return ' '.join('%.4g' % v for v in seen) + ('' if not warns or warns in said else ' (not told)'), right

    def run(self, case, devices):
        for _, file, _, expected, _, _, options in case.questions:
            for device in devices:
                for drawn in (file, *([expected] if isinstance(expected, str) else [])):
                    self.begin(device, drawn, options)
        for question in case.questions:
            expected = question[3] if not isinstance(question[3], str) else 'as ' + os.path.basename(question[3])
            cells, right = [], True
            for device in devices:
                seen, good = self.answer(device, question, devices)
                cells.append('%-24s' % seen)
                right = right and good
            self.passed, self.failed = self.passed + right, self.failed + (not right)
            shown = expected if isinstance(expected, str) else ' '.join('%.4g' % v for v in expected)
            print('%-19s %-52s %-22s %s %s' % (case.name, question[0], shown, ' '.join(cells), 'right' if right else 'WRONG'), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('names', nargs='*')
    parser.add_argument('--program', default='build/release/heliograph')
    parser.add_argument('--devices', default='embree,vulkan')
    options = parser.parse_args()
    devices = options.devices.split(',')
    print('%-19s %-52s %-22s %s' % ('case', 'question', 'right', ' '.join('%-24s' % d for d in devices)))
    with tempfile.TemporaryDirectory() as folder:
        runner = Runner(os.path.abspath(options.program), folder)
        for make in CASES:
            if options.names and make.__name__ not in options.names:
                continue
            case = Case(make.__name__, os.path.join(folder, make.__name__))
            make(case)
            runner.run(case, devices[:1] if make in READING else devices)
    print(f'{runner.passed} passed, {runner.failed} failed')
    sys.exit(runner.failed > 0 or runner.passed == 0)


if __name__ == '__main__':
    main()
