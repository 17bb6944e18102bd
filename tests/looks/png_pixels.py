"""Reads the PNG files that the project writes: eight bits, RGB or RGBA, not interlaced."""
import struct, zlib


def pixels_of(data):
    """(width, height, rows), each row a bytes of RGB. ValueError where it is no such PNG."""
    if data[:8] != b'\x89PNG\r\n\x1a\n':
        raise ValueError('not a PNG file')
    at, packed, header = 8, b'', None
    while at + 8 <= len(data):
        length, name = struct.unpack_from('>I4s', data, at)
        body = data[at + 8:at + 8 + length]
        if name == b'IHDR':
            header = struct.unpack('>IIBBBBB', body)
        elif name == b'IDAT':
            packed += body
        at += 12 + length
    if header is None or header[2] != 8 or header[3] not in (2, 6) or header[6] != 0:
        raise ValueError(f'a PNG of another kind: {header}, allowed: 8 bits, RGB or RGBA, not interlaced')
    width, height, channels = header[0], header[1], 3 if header[3] == 2 else 4
    rows = unfiltered(zlib.decompress(packed), width * channels, height, channels)
    if channels == 4:
        rows = [bytes(v for i, v in enumerate(row) if i % 4 != 3) for row in rows]
    return width, height, rows


def unfiltered(raw, stride, height, channels):
    """The rows, after each one's filter is undone (PNG specification, section 9)."""
    rows, above = [], bytes(stride)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride if kind else 0):
            left = row[i - channels] if i >= channels else 0
            corner = above[i - channels] if i >= channels else 0
            row[i] = (row[i] + predicted(kind, left, above[i], corner)) & 255
        rows.append(bytes(row))
        above = row
    return rows


def predicted(kind, left, up, corner):
    if kind < 4:
        return (0, left, up, (left + up) // 2)[kind]
    estimate = left + up - corner
    return min((abs(estimate - left), 0, left), (abs(estimate - up), 1, up), (abs(estimate - corner), 2, corner))[2]
