"""Radiance pictures as other programs write them: packings, headers, exposures. They are the surroundings here."""
import math

from files import Gltf, SQUARE, SQUARE_INDICES, at, rgbe

WIDTH, HEIGHT = 32, 16


def middle(rows):
    return at(rows, .5, .5)


def color(x, y):
    """Upper half red 2, lower half green 1; a blue column about u = 0.75."""
    return (0, 0, 4) if 22 <= x < 26 and 4 <= y < 12 else (2, 0, 0) if y < HEIGHT // 2 else (0, 1, 0)


def flat(scale=1):
    return b''.join(rgbe([v * scale for v in color(x, y)]) for y in range(HEIGHT) for x in range(WIDTH))


def packed(scale=1):
    """Each row by channels, in runs (128 + count, value) and copies (count, values)."""
    content = b''
    for y in range(HEIGHT):
        row = [rgbe([v * scale for v in color(x, y)]) for x in range(WIDTH)]
        content += bytes([2, 2, WIDTH >> 8, WIDTH & 255])
        for channel in range(4):
            values = bytes(pixel[channel] for pixel in row)
            content += bytes([128 + 20, values[0]]) if len(set(values[:20])) == 1 else bytes([20]) + values[:20]
            content += bytes([WIDTH - 20]) + values[20:]
    return content


def old(scale=1):
    """Repeats of the pixel before as (1, 1, 1, count)."""
    content = b''
    for y in range(HEIGHT):
        x = 0
        while x < WIDTH:
            run = 1
            while x + run < WIDTH and color(x + run, y) == color(x, y):
                run += 1
            content += rgbe([v * scale for v in color(x, y)]) + (bytes([1, 1, 1, run - 1]) if run > 1 else b'')
            x += run
    return content


def radiance_files(case):
    scene = Gltf()
    scene.node(mesh=scene.mesh([(x * .001, y * .001, z - 1000) for x, y, z in SQUARE], SQUARE_INDICES, scene.unlit()))
    half = math.sqrt(.5)
    for name, rotation in (('up', (half, 0, 0, half)), ('down', (-half, 0, 0, half)), ('right', (0, -half, 0, half))):
        scene.camera((0, 0, 0), 10, rotation, name)
    scene.save(case.path('sky.gltf'))
    size = f'\n-Y {HEIGHT} +X {WIDTH}\n'.encode()
    plain = b'#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n'
    kinds = {'flat': plain + size + flat(), 'runs by channel': plain + size + packed(), 'old runs': plain + size + old(),
             '#?RGBE': plain.replace(b'RADIANCE', b'RGBE') + size + packed(), 'no FORMAT': b'#?RADIANCE\n' + size + packed(),
             'two exposures': plain + b'EXPOSURE=4\nEXPOSURE= 0.5\n' + size + packed(2),
             'comments and variables': plain + b'# made by hand\nSOFTWARE=none\nVIEW= -vtv -vh 45\nGAMMA=1\nPRIMARIES=0 0 0 0 0 0 0 0\n' + size + packed()}
    for name, content in kinds.items():
        file = case.write(name.replace(' ', '-').replace('?', '') + '.hdr', content)
        for view, seen in (('up', (2, 0, 0)), ('down', (0, 1, 0)), ('right', (0, 0, 4))):
            case.ask(f'{name}, {view}', case.path('sky.gltf'), middle, seen, .03, options=('--environment', file, '--camera', view))


CASES = [radiance_files]
