"""Scenes far from the origin look as they do near it, on every device alike; and what their loading tells."""
import math

from files import Gltf, at, deviation, mean


def ball(rings=24, offset=(0, 0, 0), digits=9):
    """Vertices and triangles of a unit sphere."""
    vertices, triangles = [], []
    for i in range(rings + 1):
        for j in range(2 * rings):
            polar, turn = math.pi * i / rings, math.pi * j / rings
            at_ = (math.sin(polar) * math.cos(turn), math.cos(polar), math.sin(polar) * math.sin(turn))
            vertices.append(tuple(round(a + o, digits) for a, o in zip(at_, offset)))
    for i in range(rings):
        for j in range(2 * rings):
            a, b = i * 2 * rings + j, i * 2 * rings + (j + 1) % (2 * rings)
            triangles += [(a, b, b + 2 * rings), (a, b + 2 * rings, a + 2 * rings)]
    return vertices, triangles


def look(rows):
    return mean(rows)[:1] + [deviation(rows)] + [at(rows, x, y)[0] for x, y in ((.5, .5), (.3, .4), (.7, .6))]


def far_away(case):
    vertices, triangles = ball()
    for power in (10, 20, 22, 24):
        scene = Gltf()
        white = scene.add('materials', {'pbrMetallicRoughness': {'metallicFactor': 0, 'roughnessFactor': .6}})
        mesh = scene.mesh(vertices, [i for t in triangles for i in t], white, NORMAL=scene.accessor(vertices))
        place = [2.0 ** power, 0, 0]
        scene.node(mesh=mesh, translation=place)
        scene.light(place, [0, 0, 0, 1], type='directional', intensity=3)
        scene.camera((place[0], 0, 3), 50)
        scene.save(case.path(f'{power}.gltf'))
        case.ask(f'a sphere at 2^{power} m', case.path(f'{power}.gltf'), look, case.path('10.gltf'), 2e-4, warns=str(2 ** power) if power > 12 else None)
        case.alike(case.path(f'{power}.gltf'))


def map_coordinates(case):
    for name, offset in (('near', (0, 0, 0)), ('map', (512345.6, 102, 5403210.7))):
        vertices, triangles = ball(offset=offset)
        text = ''.join('v %.9f %.9f %.9f\n' % v for v in vertices) + 's 1\n' + ''.join('f %d %d %d\n' % tuple(i + 1 for i in t) for t in triangles)
        case.write(name + '.obj', text)
    case.ask('an OBJ in coordinates of a map', case.path('map.obj'), look, case.path('near.obj'), 2e-3, warns='5403210')
    case.alike(case.path('map.obj'))


CASES = [far_away, map_coordinates]
