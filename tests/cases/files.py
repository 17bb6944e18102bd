"""Small scene files, made from nothing: glTF with data inside, PNG, Radiance; and pixels of an OpenEXR film."""
import base64, json, math, struct, zlib


def data(kind, content):
    return f'data:{kind};base64,' + base64.b64encode(content).decode()


def png(width, height, rgb):
    """8 bits; rgb(x, y) gives three numbers from 0 to 255."""
    rows = b''.join(b'\0' + bytes(v for x in range(width) for v in rgb(x, y)) for y in range(height))
    chunk = lambda name, body: struct.pack('>I', len(body)) + name + body + struct.pack('>I', zlib.crc32(name + body))
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, 2, 0, 0, 0)) +
            chunk(b'IDAT', zlib.compress(rows)) + chunk(b'IEND', b''))


def rgbe(color):
    most = max(color)
    if most <= 0:
        return b'\0\0\0\0'
    fraction, exponent = math.frexp(most)
    return bytes(int(v * fraction * 256 / most) for v in color) + bytes([exponent + 128])


class Gltf:
    """A scene under construction; everything is in one buffer inside the file."""
    KINDS = {1: 'SCALAR', 2: 'VEC2', 3: 'VEC3', 4: 'VEC4'}
    FORMATS = {5120: 'b', 5121: 'B', 5122: 'h', 5123: 'H', 5125: 'I', 5126: 'f'}

    def __init__(self):
        self.bytes = b''
        self.root = {'asset': {'version': '2.0'}, 'scene': 0, 'scenes': [{'nodes': []}]}

    def add(self, array, value):
        self.root.setdefault(array, []).append(value)
        return len(self.root[array]) - 1

    def accessor(self, rows, component=5126, **more):
        """rows: numbers, or tuples of them."""
        rows = [row if isinstance(row, tuple) else (row,) for row in rows]
        self.bytes += b'\0' * (-len(self.bytes) % 4)
        content = b''.join(struct.pack('<%d%s' % (len(row), self.FORMATS[component]), *row) for row in rows)
        view = self.add('bufferViews', {'buffer': 0, 'byteOffset': len(self.bytes), 'byteLength': len(content)})
        self.bytes += content
        bounds = {'min': [min(c) for c in zip(*rows)], 'max': [max(c) for c in zip(*rows)]} if component == 5126 else {}
        return self.add('accessors', {'bufferView': view, 'componentType': component, 'count': len(rows),
                                      'type': self.KINDS[len(rows[0])], **bounds, **more})

    def mesh(self, positions, indices, material=None, **attributes):
        used = {'POSITION': self.accessor(positions), **{name: index for name, index in attributes.items()}}
        primitive = {'attributes': used, 'indices': self.accessor(indices, 5125)}
        if material is not None:
            primitive['material'] = material
        return self.add('meshes', {'primitives': [primitive]})

    def node(self, **properties):
        index = self.add('nodes', properties)
        self.root['scenes'][0]['nodes'].append(index)
        return index

    def uses(self, extension):
        if extension not in self.root.setdefault('extensionsUsed', []):
            self.root['extensionsUsed'].append(extension)

    def light(self, translation, rotation, **light):
        self.uses('KHR_lights_punctual')
        lights = self.root.setdefault('extensions', {}).setdefault('KHR_lights_punctual', {'lights': []})['lights']
        lights.append(light)
        self.node(translation=translation, rotation=rotation, extensions={'KHR_lights_punctual': {'light': len(lights) - 1}})

    def camera(self, translation, degrees=60, rotation=(0, 0, 0, 1), name='eye'):
        lens = self.add('cameras', {'type': 'perspective', 'name': name, 'perspective': {'yfov': math.radians(degrees), 'znear': .01}})
        self.node(camera=lens, translation=list(translation), rotation=list(rotation))

    def unlit(self, **pbr):
        self.uses('KHR_materials_unlit')
        return self.add('materials', {'pbrMetallicRoughness': pbr, 'extensions': {'KHR_materials_unlit': {}}})

    def save(self, path):
        self.root['buffers'] = [{'byteLength': len(self.bytes), 'uri': data('application/octet-stream', self.bytes)}]
        with open(path, 'w') as file:
            json.dump(self.root, file)


SQUARE = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]
SQUARE_INDICES = [0, 1, 2, 0, 2, 3]
SQUARE_UV = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)]


def film(path):
    """Rows of (red, green, blue) of an OpenEXR file with 32-bit floats, uncompressed or ZIP."""
    content = open(path, 'rb').read()
    at, header = 8, {}
    while content[at]:
        name = content[at:content.index(b'\0', at)]
        at += len(name) + 1
        at = content.index(b'\0', at) + 1
        size, = struct.unpack_from('<i', content, at)
        header[name.decode()] = content[at + 4:at + 4 + size]
        at += 4 + size
    at += 1
    left, top, right, bottom = struct.unpack('<4i', header['dataWindow'])
    width, height = right - left + 1, bottom - top + 1
    channels, list_ = [], header['channels']
    while list_[0]:
        end = list_.index(b'\0')
        channels.append(list_[:end].decode())
        list_ = list_[end + 17:]
    per_block = {0: 1, 2: 1, 3: 16}[header['compression'][0]]
    offsets = struct.unpack_from('<%dQ' % -(-height // per_block), content, at)
    rows = [[[0.0] * 3 for _ in range(width)] for _ in range(height)]
    for offset in offsets:
        first, size = struct.unpack_from('<ii', content, offset)
        block = content[offset + 8:offset + 8 + size]
        count = min(per_block, height - (first - top))
        if size < count * width * 4 * len(channels):
            packed = bytearray(zlib.decompress(block))
            for i in range(1, len(packed)):
                packed[i] = (packed[i - 1] + packed[i] - 128) & 255
            half = (len(packed) + 1) // 2
            block = bytearray(len(packed))
            block[0::2], block[1::2] = packed[:half], packed[half:]
        for row in range(count):
            for k, channel in enumerate(channels):
                if channel not in 'RGB':
                    continue
                values = struct.unpack_from('<%df' % width, block, (row * len(channels) + k) * width * 4)
                for x, value in enumerate(values):
                    rows[first - top + row][x]['RGB'.index(channel)] = value
    return rows


def at(rows, x, y):
    """Mean of 3 x 3 pixels about shares of width and height."""
    j, i = int(y * len(rows)), int(x * len(rows[0]))
    near = [rows[b][a] for b in range(max(j - 1, 0), min(j + 2, len(rows))) for a in range(max(i - 1, 0), min(i + 2, len(rows[0])))]
    return [sum(p[k] for p in near) / len(near) for k in range(3)]


def mean(rows):
    return [sum(p[k] for row in rows for p in row) / len(rows) / len(rows[0]) for k in range(3)]


def deviation(rows):
    """Standard deviation of red over the middle nine tenths."""
    margin = len(rows) // 20
    values = [p[0] for row in rows[margin:-margin] for p in row[margin:-margin]]
    middle = sum(values) / len(values)
    return math.sqrt(sum((v - middle) ** 2 for v in values) / len(values))
