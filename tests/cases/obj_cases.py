"""OBJ and MTL files as other programs write them: ends of lines, blanks, numbers, indices, options of maps, names."""
from files import at, png

FACING = ('--camera', '0,0,1:0,0,0:90')  # all of the square is the picture, u to the right, v up
SQUARE = 'v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n'
FACE = 'f 1/1/1 2/2/1 3/3/1 4/4/1\n'
RED = 'newmtl m\nKd 0 0 0\nKe 1 0 0\n'
QUARTERS = png(16, 16, lambda x, y: (255 * (x >= 8), 255 * (y >= 8), 0))  # u >= 0.5 has red, v < 0.5 has green


def middle(rows):
    return at(rows, .5, .5)


def left_low(rows):
    return at(rows, .25, .75)


def write(case, name, mtl, face=FACE, shape=SQUARE, code='utf-8', mtllib=None, pictures=('p.png',)):
    for picture in pictures:
        case.write(name + '/' + picture, QUARTERS)
    case.write(f'{name}/{mtllib or "m.mtl"}', mtl.encode(code))
    return case.write(f'{name}/a.obj', f'mtllib {mtllib or "m.mtl"}\n{shape}usemtl m\n{face}'.encode(code))


def obj_text(case):
    def ends(name, change):
        case.ask(name, case.write(f'{name}/a.obj', change('mtllib m.mtl\n' + SQUARE + 'usemtl m\n' + FACE)), middle, (1, 0, 0),
                 options=FACING)

    for name, change in (('CR LF', lambda s: s.replace('\n', '\r\n')), ('CR', lambda s: s.replace('\n', '\r')),
                         ('tabs', lambda s: s.replace(' ', '\t')), ('blanks at the ends', lambda s: s.replace('\n', ' \t\n')),
                         ('blanks before', lambda s: s.replace('\n', '\n  \t')), ('doubled blanks', lambda s: s.replace(' ', '   ')),
                         ('no line feed at the end', lambda s: s[:-1]), ('empty lines', lambda s: s.replace('\n', '\n\n')),
                         ('a continued line with CR LF', lambda s: s.replace(' 3/3/1', ' \\\n 3/3/1').replace('\n', '\r\n')),
                         ('comments behind', lambda s: s.replace('\n', ' # so\n')),
                         ('groups, objects, smoothing', lambda s: 'o one\ng\n' + s.replace('usemtl', 'g a b\ns off\no two three\ns 1\nusemtl'))):
        case.write(f'{name}/m.mtl', change(RED))
        ends(name, change)
    for code in ('utf-16-le', 'utf-16-be'):
        mark = '\ufeff'
        case.write(f'{code}/m.mtl', (mark + RED).encode(code))
        case.ask('text in ' + code, case.write(f'{code}/a.obj', (mark + 'mtllib m.mtl\n' + SQUARE + 'usemtl m\n' + FACE).encode(code)),
                 middle, (1, 0, 0), options=FACING)


def obj_numbers(case):
    shapes = {'plus signs': 'v -1 -1 +0\nv +1 -1 0\nv +1 +1 0\nv -1 +1 0\n', 'bare points': 'v -1. -1. .0\nv 1. -1. -.0\nv 1. 1. 0.\nv -1. 1. 0\n',
              'exponents': 'v -1e0 -10E-1 0\nv 1e+00 -.1E+1 0e5\nv 1 1 0\nv -1 1 0\n', 'a fourth number': 'v -1 -1 0 1\nv 1 -1 0 1.0\nv 1 1 0 1\nv -1 1 0 1\n'}
    for name, shape in shapes.items():
        case.ask(name, write(case, name, RED, 'f 1 2 3 4\n', shape), lambda f: middle(f) + at(f, .03, .03)[:1], (1, 0, 0, 1), options=FACING)
    faces = {'negative indices': 'f -4/-4/-1 -3/-3/-1 -2/-2/-1 -1/-1/-1\n', 'positions alone': 'f 1 2 3 4\n', 'texture alone': 'f 1/1 2/2 3/3 4/4\n',
             'normals alone': 'f 1//1 2//1 3//1 4//1\n', 'negative normals alone': 'f -4//-1 -3//-1 -2//-1 -1//-1\n',
             'two triangles': 'f 1 2 3\nf 1 3 4\n', 'fo, as faces once were called': 'fo 1 2 3 4\n', 'corners of several kinds': 'f 1/1 2/2/1 3 4//1\n'}
    for name, face in faces.items():
        case.ask(name, write(case, name, RED, face), lambda f: middle(f) + at(f, .03, .03)[:1], (1, 0, 0, 1), options=FACING)
    twice = SQUARE + 'usemtl m\nf -4 -3 -2\n' + 'v -1 -1 0\nv 1 1 0\nv -1 1 0\n'
    case.ask('negative indices count from where they stand', write(case, 'twice', RED, 'f -3 -2 -1\n', twice),
             lambda f: at(f, .3, .5)[:1] + at(f, .7, .5)[:1], (1, 1), options=FACING)


def obj_maps(case):
    """The colour at u 0.25, v 0.25 is green; options and names lead elsewhere or nowhere."""
    lines = {'plain': ('map_Ke p.png', (0, 1, 0)), 'tab': ('map_Ke\tp.png', (0, 1, 0)), '-o': ('map_Ke -o 0.5 0 0 p.png', (1, 1, 0)),
             '-o of one number': ('map_Ke -o 0.5 p.png', (1, 1, 0)), '-o upwards': ('map_Ke -o 0 .5 p.png', (0, 0, 0)),
             '-s': ('map_Ke -s 3 1 1 p.png', (1, 1, 0)), '-s -o': ('map_Ke -s 3 1 1 -o 0.5 0 0 p.png', (0, 1, 0)),
             '-clamp': ('map_Ke -clamp on -o 5 0 p.png', (1, 1, 0)), 'many': ('map_Ke -blendu off -blendv on -cc on -texres 512 -mm 0 1 -t 0 0 0 -imfchan l p.png', (0, 1, 0)),
             'quoted': ('map_Ke "p.png"', (0, 1, 0)), 'quoted blanks': ('map_Ke "a b.png"', (0, 1, 0)), 'blanks': ('map_Ke a b.png', (0, 1, 0)),
             'dot': ('map_Ke ./p.png', (0, 1, 0)), 'backslashes': ('map_Ke .\\sub\\q.png', (0, 1, 0)), '#': ('map_Ke c#1.png', (0, 1, 0)),
             'other case': ('map_Ke P.PNG', (0, 1, 0)), 'keys in capitals': ('MAP_KE p.png', (0, 1, 0)), 'a comment behind': ('map_Ke p.png # so', (0, 1, 0))}
    for name, (line, seen) in lines.items():
        file = write(case, 'map ' + name, f'newmtl m\nKd 0 0 0\nKe 1 1 1\n{line}\n', pictures=('p.png', 'a b.png', 'sub/q.png', 'c#1.png'))
        case.ask(name, file, left_low, seen, options=FACING)


def obj_materials_kinds(case):
    """White glows behind what is asked about, at z = -1."""
    behind = SQUARE + 'v -9 -9 -1\nv 9 -9 -1\nv 9 9 -1\nv -9 9 -1\nusemtl back\nf 5 6 7 8\n'
    back = 'newmtl back\nKd 0 0 0\nKe 1 1 1\n'
    kinds = {'d': ('d 0.25', (.75 + .25, .75, .75)), 'Tr': ('Tr 0.75', (1, .75, .75)), 'd and Tr': ('Tr 0.9\nd 0.25', (1, .75, .75)),
             'Tr and d that agree': ('d 0.25\nTr 0.75', (1, .75, .75)), 'd 1': ('d 1', (1, 0, 0)), 'Tr 0': ('Tr 0', (1, 0, 0)), 'd -halo': ('d -halo 0.25', (1, .75, .75)),
             'Ke of one number': ('Ke 0.5', (.5, .5, .5)), 'Ke in blanks': ('Ke   0.5   0   0.25', (.5, 0, .25)), 'Ke 3 times white': ('Ke 3 3 3', (3, 3, 3)),
             'unknown keys': ('Ka 1 1 1\nKs 0 0 0\nsharpness 60\nPcr 0\naniso 0\nNi 1\nillum 2', (1, 0, 0)), 'the later one': ('Ke 0 1 0\nKe 0 0 1', (0, 0, 1))}
    for name, (lines, seen) in kinds.items():
        case.ask(name, write(case, 'kind ' + name, back + RED + lines + '\n', FACE, behind), middle, seen, .012, options=FACING)
    for name, mtllib in (('a name with #', 'a#1.mtl'), ('a quoted name', None), ('another case', None), ('backslashes', None)):
        file = write(case, 'lib ' + name, RED, mtllib=mtllib)
        if mtllib is None:
            said = {'a quoted name': '"m.mtl"', 'another case': 'M.MTL', 'backslashes': '.\\m.mtl'}[name]
            file = case.write(f'lib {name}/b.obj', f'mtllib {said}\n{SQUARE}usemtl m\n{FACE}')
        case.ask(name, file, middle, (1, 0, 0), options=FACING)
    file = write(case, 'twice', RED + 'newmtl m\nKd 0 0 0\nKe 0 1 0\n')
    case.ask('a material twice: told', file, lambda f: [max(middle(f))], (1,), warns="'m'", options=FACING)
    file = case.write('late/a.obj', f'{SQUARE}usemtl m\n{FACE}mtllib m.mtl\n')
    case.write('late/m.mtl', RED)
    case.ask('mtllib after usemtl', file, middle, (1, 0, 0), options=FACING)


CASES = [obj_text, obj_numbers, obj_maps, obj_materials_kinds]
