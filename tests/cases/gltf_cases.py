"""glTF files as other programs write them: layouts of vertices, textures and their coordinates, instances, names, containers."""
import base64, json, math, struct, urllib.parse

from files import Gltf, SQUARE, SQUARE_INDICES, SQUARE_UV, at, data, png

QUARTERS = png(64, 64, lambda x, y: (255 * (x >= 32), 255 * (y >= 32), 0))  # u >= 0.5 has red, v >= 0.5 has green


def middle(rows):
    return at(rows, .5, .5)


def corners(rows):
    """Red and green left above, right above, left below, right below."""
    return [round(value, 3) for y in (.25, .75) for x in (.25, .75) for value in at(rows, x, y)[:2]]


PLAIN = (0, 0, 1, 0, 0, 1, 1, 1)


def facing(scene):
    """All of the square is the picture."""
    scene.camera((0, 0, 1), 90)
    return scene


def textured(case, name, uri=None, sampler=None, info=None, extensions=(), uv=SQUARE_UV, uv1=None, save=True, picture=QUARTERS):
    scene = Gltf()
    scene.add('images', {'uri': uri or data('image/png', picture)})
    texture = {'source': 0}
    if sampler is not None:
        texture['sampler'] = scene.add('samplers', sampler)
    scene.add('textures', texture)
    for extension in extensions:
        scene.uses(extension)
    material = scene.unlit(baseColorTexture={'index': 0, **(info or {})})
    attributes = {'TEXCOORD_0': scene.accessor(uv)}
    if uv1:
        attributes['TEXCOORD_1'] = scene.accessor(uv1)
    scene.node(mesh=scene.mesh(SQUARE, SQUARE_INDICES, material, **attributes))
    facing(scene)
    if save:
        scene.save(case.path(name + '.gltf'))
        return case.path(name + '.gltf')
    return scene


def sampler_wraps(case):
    far = [(u * 2 + 1, v * 2 + 1) for u, v in SQUARE_UV]  # the middle of the picture is (2, 2)
    edge = {'repeat': (10497, PLAIN), 'mirrored': (33648, None), 'clamp': (33071, (1, 1) * 4)}
    for name, (wrap, seen) in edge.items():
        file = textured(case, name, sampler={'wrapS': wrap, 'wrapT': wrap}, uv=[(u * .5 + 1.25, v * .5 + 1.25) for u, v in SQUARE_UV])
        # From (1.25, 1.25) to (1.75, 1.75): repeated the picture's middle, mirrored the same turned about.
        expected = PLAIN if wrap == 10497 else (1, 1, 0, 1, 1, 0, 0, 0) if wrap == 33648 else seen
        case.ask('wrap ' + name, file, corners, expected)
    file = textured(case, 'each', sampler={'wrapS': 33648, 'wrapT': 33071}, uv=[(u * .5 + 1.25, v * .5 + 1.25) for u, v in SQUARE_UV])
    case.ask('each direction its own', file, corners, (1, 1, 0, 1, 1, 1, 0, 1))
    case.ask('a sampler that says nothing repeats', textured(case, 'empty', sampler={}, uv=[(u + 7, v - 3) for u, v in SQUARE_UV]), corners, PLAIN)


def texture_places(case):
    use = ('KHR_texture_transform',)
    moved = lambda **t: {'extensions': {'KHR_texture_transform': t}}
    other = [(0.0, 0.0)] * 4
    case.ask('moved by half', textured(case, 'offset', info=moved(offset=[.5, 0]), extensions=use), corners, (1, 0, 0, 0, 1, 1, 0, 1))
    case.ask('on the second coordinates', textured(case, 'second', info={'texCoord': 1, **moved(offset=[.5, 0])}, extensions=use, uv=other, uv1=SQUARE_UV),
             corners, (1, 0, 0, 0, 1, 1, 0, 1))
    case.ask('its own texCoord comes first', textured(case, 'over', info={'texCoord': 0, **moved(offset=[.5, 0], texCoord=1)}, extensions=use, uv=other, uv1=SQUARE_UV),
             corners, (1, 0, 0, 0, 1, 1, 0, 1))
    case.ask('turned by a quarter', textured(case, 'turned', info=moved(rotation=math.pi / 2), extensions=use), corners,
             (0, 1, 0, 0, 1, 1, 1, 0))
    for kind, component, scale in (('bytes', 5121, 255), ('words', 5123, 65535)):
        scene = textured(case, kind, save=False)
        uv = scene.accessor([(round(u * scale), round(v * scale)) for u, v in SQUARE_UV], component, normalized=True)
        if component == 5121:  # each vertex is aligned to 4 bytes
            view = scene.root['bufferViews'][-1]
            rows = [(round(u * scale), round(v * scale), 0, 0) for u, v in SQUARE_UV]
            scene.bytes = scene.bytes[:view['byteOffset']] + b''.join(struct.pack('4B', *row) for row in rows)
            view.update(byteLength=16, byteStride=4)
        scene.root['meshes'][0]['primitives'][0]['attributes']['TEXCOORD_0'] = uv
        scene.save(case.path(kind + '.gltf'))
        case.ask('coordinates of ' + kind, case.path(kind + '.gltf'), corners, PLAIN)


def names_and_data(case):
    names = {'blank': ('a b.png', 'a b.png'), 'blank as %20': ('a b.png', 'a%20b.png'), '#': ('a#b.png', 'a%23b.png'), '%': ('a%b.png', 'a%25b.png'),
             'umlaut': ('\u00fc.png', '\u00fc.png'), 'umlaut as UTF-8': ('\u00fc.png', '%C3%BC.png'), 'dot': ('p.png', './p.png'),
             'folder': ('sub/p.png', 'sub/p.png'), 'another case': ('p.png', 'P.PNG'), 'plus is no blank': ('a+b.png', 'a+b.png')}
    for name, (file, uri) in names.items():
        case.write(file, QUARTERS)
        case.ask('a name with ' + name, textured(case, 'name ' + name, uri), corners, PLAIN)
    text = base64.b64encode(QUARTERS).decode()
    for name, uri in {'a charset': 'data:image/png;charset=utf-8;base64,' + text, 'no type': 'data:;base64,' + text, 'octets': 'data:application/octet-stream;base64,' + text,
                      'a wrong type': 'data:image/jpeg;base64,' + text, 'capitals': 'data:image/png;BASE64,' + text, 'no padding': 'data:image/png;base64,' + text.rstrip('='),
                      'lines': 'data:image/png;base64,' + '\n'.join(text[i:i + 60] for i in range(0, len(text), 60)),
                      'escapes': 'data:image/png;base64,' + urllib.parse.quote(text, safe=''), 'no base64': 'data:image/png,' + urllib.parse.quote_from_bytes(QUARTERS)}.items():
        case.ask('data with ' + name, textured(case, 'data ' + name, uri), corners, PLAIN)


def glb(root, binary, *more, first=None):
    text = json.dumps(root).encode()
    chunk = lambda name, body, pad: struct.pack('<I4s', len(body) + -len(body) % 4, name) + body + pad * (-len(body) % 4)
    body = chunk(b'JSON', text, b' ') + chunk(b'BIN\0', binary, b'\0') + b''.join(chunk(name, content, b'\0') for name, content in more)
    return struct.pack('<4sII', b'glTF', 2, 12 + len(body)) + body


def containers(case):
    scene = textured(case, 'glb', save=False)
    scene.root['buffers'] = [{'byteLength': len(scene.bytes)}]
    kinds = {'plain': glb(scene.root, scene.bytes), 'another chunk behind': glb(scene.root, scene.bytes, (b'MINE', b'12345')),
             'bytes behind its length': glb(scene.root, scene.bytes) + b'behind'}
    for name, content in kinds.items():
        case.ask('GLB: ' + name, case.write(name.replace(' ', '-') + '.glb', content), corners, PLAIN)
    case.ask('GLB that is called .gltf', case.write('is-glb.gltf', kinds['plain']), corners, PLAIN)
    text = json.dumps({**scene.root, 'buffers': [{'byteLength': len(scene.bytes), 'uri': data('application/gltf-buffer', scene.bytes)}]})
    case.ask('JSON that is called .glb', case.write('is-json.glb', text), corners, PLAIN)
    case.ask('a byte order mark', case.write('mark.gltf', '\ufeff' + text), corners, PLAIN)
    root = json.loads(text)
    for array in ('nodes', 'meshes', 'materials', 'textures', 'images', 'accessors', 'bufferViews', 'buffers', 'cameras', 'scenes'):
        for one in root[array]:
            one['extras'] = {'name': 'x', 'list': [1, {'extensions': 3}], 'none': None}
    root['extras'], root['asset']['extras'] = 'text', 7
    case.ask('extras everywhere', case.write('extras.gltf', json.dumps(root)), corners, PLAIN)


def vertex_alpha(case):
    """Colours of vertices with alpha 0.25, over white; only where the material blends or cuts."""
    for name, component, one in (('bytes', 5121, 255), ('words', 5123, 65535), ('floats', 5126, 1.0)):
        for mode, seen in (('OPAQUE', (1, 0, 0)), ('BLEND', (1, .75, .75)), ('MASK', (1, 1, 1))):
            scene = Gltf()
            material = scene.unlit()
            scene.root['materials'][material]['alphaMode'] = mode
            quarter = one * .25 if component == 5126 else round(one * .25)
            more = {} if component == 5126 else {'normalized': True}
            scene.node(mesh=scene.mesh(SQUARE, SQUARE_INDICES, material, COLOR_0=scene.accessor([(one, 0 * one, 0 * one, quarter)] * 4, component, **more)))
            scene.node(mesh=scene.mesh([(x * 9, y * 9, -1.0) for x, y, z in SQUARE], SQUARE_INDICES, scene.unlit()))
            facing(scene).save(case.path(f'{name}{mode}.gltf'))
            case.ask(f'{name}, {mode}', case.path(f'{name}{mode}.gltf'), middle, seen, .005)
    scene = Gltf()
    scene.node(mesh=scene.mesh(SQUARE, SQUARE_INDICES, scene.unlit(baseColorFactor=[.5, 1, 1, 1]), COLOR_0=scene.accessor([(.5, .5, 2.0)] * 4)))
    facing(scene).save(case.path('factor.gltf'))
    case.ask('times the factor', case.path('factor.gltf'), lambda f: middle(f)[:2], (.25, .5))


def vertex_layouts(case):
    red = [1, 0, 0, 1]
    half = lambda f: [at(f, .25, .5)[0], at(f, .75, .5)[0]]

    def saved(name, scene, seen, what):
        facing(scene).save(case.path(name + '.gltf'))
        case.ask(what, case.path(name + '.gltf'), half, seen, .02)

    def quantised(scene, normalized, scale):
        scene.uses('KHR_mesh_quantization')
        index = scene.accessor([(round(x * scale), round(y * scale), 0) for x, y, z in SQUARE], 5122, **({'normalized': True} if normalized else {}))
        accessor = scene.root['accessors'][index]
        view = scene.root['bufferViews'][accessor['bufferView']]
        rows = [(round(x * scale), round(y * scale), 0, 0) for x, y, z in SQUARE]
        scene.bytes = scene.bytes[:view['byteOffset']] + b''.join(struct.pack('<4h', *row) for row in rows)
        view.update(byteLength=32, byteStride=8)
        accessor.update(min=[-scale, -scale, 0], max=[scale, scale, 0])
        return index

    for name, normalized, scale in (('normalised', True, 32767), ('whole', False, 100)):
        scene = Gltf()
        indices = scene.accessor(SQUARE_INDICES, 5125)
        position = quantised(scene, normalized, scale)
        sparse = {'count': 2, 'indices': {'bufferView': 0, 'componentType': 5121}, 'values': {'bufferView': 0}}
        for key, rows, form in (('indices', [(1,), (2,)], 'B'), ('values', [(0, -scale, 0), (0, scale, 0)], 'h')):
            scene.bytes += b'\0' * (-len(scene.bytes) % 4)
            content = b''.join(struct.pack('<%d%s' % (len(row), form), *row) for row in rows)
            sparse[key]['bufferView'] = scene.add('bufferViews', {'buffer': 0, 'byteOffset': len(scene.bytes), 'byteLength': len(content)})
            scene.bytes += content
        scene.root['accessors'][position]['sparse'] = sparse
        mesh = scene.add('meshes', {'primitives': [{'attributes': {'POSITION': position}, 'indices': indices, 'material': scene.unlit(baseColorFactor=red)}]})
        scene.node(mesh=mesh, scale=[1, 1, 1] if normalized else [.01] * 3)
        scene.node(mesh=scene.mesh([(x * 9, y * 9, -1.0) for x, y, z in SQUARE], SQUARE_INDICES, scene.unlit(baseColorFactor=[0, 0, 0, 1])))
        saved('sparse-' + name, scene, (1, 0), f'sparse {name} 16-bit positions: the right half is moved away')
    for name, weights, seen in (('rest', None, (1, 1)), ('half', [.5], (1, 0)), ('node', None, (1, 0))):
        scene = Gltf()
        mesh = scene.mesh(SQUARE, SQUARE_INDICES, scene.unlit(baseColorFactor=red))
        scene.root['meshes'][mesh]['primitives'][0]['targets'] = [{'POSITION': scene.accessor([(0.0, 0.0, 0.0), (-2.0, 0.0, 0.0), (-2.0, 0.0, 0.0), (0.0, 0.0, 0.0)])}]
        if weights:
            scene.root['meshes'][mesh]['weights'] = weights
        scene.node(mesh=mesh, **({'weights': [.5]} if name == 'node' else {}))
        scene.node(mesh=scene.mesh([(x * 9, y * 9, -1.0) for x, y, z in SQUARE], SQUARE_INDICES, scene.unlit(baseColorFactor=[0, 0, 0, 1])))
        saved('morph-' + name, scene, seen, f'morphed, {name}')
    for name, mode, order in (('strip', 5, [0, 1, 3, 2]), ('fan', 6, [0, 1, 2, 3]), ('bytes', 4, SQUARE_INDICES)):
        scene = Gltf()
        mesh = scene.mesh(SQUARE, SQUARE_INDICES, scene.unlit(baseColorFactor=red))
        scene.root['meshes'][mesh]['primitives'][0].update(mode=mode, indices=scene.accessor(order, 5121))
        scene.node(mesh=mesh)
        saved('mode-' + name, scene, (1, 1), f'indices of one byte, {name}')


def instances(case):
    """Four quarter squares by EXT_mesh_gpu_instancing; lit as the same by nodes."""
    places = [(-.5, -.5, 0.0), (.5, -.5, 0.0), (-.5, .5, 0.0), (.5, .5, 0.0)]

    def scene_with(attributes, node=None):
        scene = Gltf()
        scene.uses('EXT_mesh_gpu_instancing')
        white = scene.add('materials', {'pbrMetallicRoughness': {'metallicFactor': 0, 'roughnessFactor': 1}})
        mesh = scene.mesh([(x * .25, y * .25, 0.0) for x, y, z in SQUARE], SQUARE_INDICES, white, NORMAL=scene.accessor([(.6, 0.0, .8)] * 4))
        made = {name: scene.accessor(rows, component, **({'normalized': True} if component != 5126 else {})) for name, (rows, component) in attributes.items()}
        scene.node(mesh=mesh, extensions={'EXT_mesh_gpu_instancing': {'attributes': made}}, **(node or {}))
        scene.light([0, 0, 0], [0, 0, 0, 1], type='directional', intensity=math.pi)
        return facing(scene)

    def nodes(transforms):
        scene = Gltf()
        white = scene.add('materials', {'pbrMetallicRoughness': {'metallicFactor': 0, 'roughnessFactor': 1}})
        mesh = scene.mesh([(x * .25, y * .25, 0.0) for x, y, z in SQUARE], SQUARE_INDICES, white, NORMAL=scene.accessor([(.6, 0.0, .8)] * 4))
        for transform in transforms:
            scene.node(mesh=mesh, **transform)
        scene.light([0, 0, 0], [0, 0, 0, 1], type='directional', intensity=math.pi)
        return facing(scene)

    whole = lambda f: [at(f, x, y)[0] for y in (.25, .5, .75) for x in (.25, .5, .75)]
    turn = math.sin(math.pi / 8), math.cos(math.pi / 8)
    kinds = {
        'places alone': ({'TRANSLATION': (places, 5126)}, [{'translation': list(p)} for p in places]),
        'sizes alone': ({'SCALE': ([(1.0, 1.0, 1.0), (3.0, 2.0, 1.0)], 5126)}, [{'scale': [1, 1, 1]}, {'scale': [3, 2, 1]}]),
        'mirrored': ({'TRANSLATION': (places, 5126), 'SCALE': ([(-1.0, 1.0, 1.0), (1.0, -1.0, 1.0), (-1.0, -1.0, 1.0), (1.0, 1.0, 1.0)], 5126)},
                     [{'translation': list(p), 'scale': s} for p, s in zip(places, ([-1, 1, 1], [1, -1, 1], [-1, -1, 1], [1, 1, 1]))]),
        'turned in 16 bits': ({'TRANSLATION': (places, 5126), 'ROTATION': ([(0, round(turn[0] * 32767), 0, round(turn[1] * 32767))] * 4, 5122)},
                              [{'translation': list(p), 'rotation': [0, turn[0], 0, turn[1]]} for p in places])}
    for name, (attributes, transforms) in kinds.items():
        scene_with(attributes).save(case.path(name + '.gltf'))
        nodes(transforms).save(case.path(name + ' nodes.gltf'))
        case.ask('instances: ' + name, case.path(name + '.gltf'), whole, case.path(name + ' nodes.gltf'), .002)


def looks(case):
    """KHR_materials_variants: red by itself, green in one variant, white seen through in another."""
    scene = Gltf()
    materials = [scene.unlit(baseColorFactor=c) for c in ([1, 0, 0, 1], [0, 1, 0, 1], [1, 1, 0, 0])]
    scene.root['materials'][2]['alphaMode'] = 'BLEND'
    scene.uses('KHR_materials_variants')
    scene.root.setdefault('extensions', {})['KHR_materials_variants'] = {'variants': [{'name': 'leaf'}, {'name': 'air'}]}
    mesh = scene.mesh(SQUARE, SQUARE_INDICES, materials[0])
    scene.root['meshes'][mesh]['primitives'][0]['extensions'] = {'KHR_materials_variants': {'mappings': [
        {'material': materials[1], 'variants': [0]}, {'material': materials[2], 'variants': [1]}]}}
    scene.node(mesh=mesh)
    scene.node(mesh=scene.mesh([(x * 9, y * 9, -1.0) for x, y, z in SQUARE], SQUARE_INDICES, scene.unlit(baseColorFactor=[0, 0, 1, 1])))
    facing(scene).save(case.path('looks.gltf'))
    for options, seen in (((), (1, 0, 0)), (('--variant', 'leaf'), (0, 1, 0)), (('--variant', '1'), (0, 0, 1))):
        case.ask('look ' + ' '.join(options), case.path('looks.gltf'), middle, seen, options=options)


def parallel_cameras(case):
    """Two equal squares, one three metres behind the other, are equally large; one behind the camera is told."""
    for name, height, behind in (('one', 1, False), ('small', .05, False), ('behind', 1, True)):
        scene = Gltf()
        for side, depth in ((-1, 0), (1, -3)):
            square = [((x * .25 + side * .5) * height, y * .5 * height, float(depth)) for x, y, z in SQUARE]
            scene.node(mesh=scene.mesh(square, SQUARE_INDICES, scene.unlit()))
        scene.node(mesh=scene.mesh([(x * 9, y * 9, -4.0) for x, y, z in SQUARE], SQUARE_INDICES, scene.unlit(baseColorFactor=[0, 0, 0, 1])))
        if behind:
            scene.node(mesh=scene.mesh([(x * .01, y * .01 + 20, 5.0) for x, y, z in SQUARE], SQUARE_INDICES, scene.unlit()))
        lens = scene.add('cameras', {'type': 'orthographic', 'name': 'plan', 'orthographic': {'xmag': height, 'ymag': height, 'znear': .01, 'zfar': 9}})
        scene.node(camera=lens, translation=[0, 0, 2])
        scene.save(case.path(name + '.gltf'))
        edges = lambda f: [round(at(f, x, y)[0]) for x, y in ((.16, .5), (.35, .28), (.44, .5), (.25, .2), (.56, .5), (.65, .28), (.84, .5), (.75, .2))]
        case.ask(f'a parallel camera, {name}', case.path(name + '.gltf'), edges, (1, 1, 0, 0, 0, 1, 1, 0), warns='stands behind it' if behind else 'parallel')


CASES = [sampler_wraps, texture_places, names_and_data, containers, vertex_alpha, vertex_layouts, instances, looks,
         parallel_cameras]
