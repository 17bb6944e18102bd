#!/usr/bin/env python3
"""A contact sheet of models at defaults, to be looked at: contact_sheet.py [MODEL...] draws each by `heliograph render` with no
setting but its size and samples, and writes out/looks/contact_sheet.html, one file that needs no other. Without MODELs the
first .gltf or .glb in each folder of ../shared/scenes/gltf. ./check looks judges the same models; this is for the eye.

--against PROGRAM draws another build's picture beside each, and how far the two lie apart. Under each picture stand what of it
is not the backdrop, how light that is, and words where figures are far off: black, burnt, flat, cut, empty. They are hints:
a mirror may be black, a lamp white."""
import argparse, base64, collections, html, os, subprocess, sys, tempfile, time

from png_pixels import pixels_of

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '../..'))
MODELS = os.path.join(ROOT, '../shared/scenes/gltf')
STYLE = '''body { margin: 16px; background: #2b2b2e; color: #eee; font: 13px/1.4 system-ui, sans-serif }
main { display: grid; grid-template-columns: repeat(auto-fill, minmax(%dpx, max-content)); gap: 12px }
figure { margin: 0 } img { display: inline-block; vertical-align: top; margin-right: 4px }
figcaption { max-width: %dpx } b { color: #ffb1a8 } .quiet { color: #aaa }'''


def models_below(folder):
    """The first model of each folder, by name."""
    found = []
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        files = sorted(os.path.join(at, file) for at, _, files in os.walk(os.path.join(folder, name)) for file in files
                       if file.endswith(('.gltf', '.glb')))
        found += files[:1]
    return found


def drawn(program, model, options, folder):
    """(PNG bytes or None, seconds, what was said)."""
    out = os.path.join(folder, 'picture.png')
    command = [program, 'render', model, '--out', out, '--size', options.size, '--samples', str(options.samples)]
    begin = time.monotonic()
    try:
        done = subprocess.run(command, capture_output=True, timeout=options.seconds)
    except subprocess.TimeoutExpired:
        return None, options.seconds, f'not done in {options.seconds} s'
    seconds = time.monotonic() - begin
    if done.returncode != 0:
        said = done.stderr.decode(errors='replace').strip().splitlines()[-1:] or [f'exit code {done.returncode}']
        return None, seconds, said[0]
    with open(out, 'rb') as file:
        return file.read(), seconds, ''


def luminance(row, x):
    return 0.2126 * row[3 * x] + 0.7152 * row[3 * x + 1] + 0.0722 * row[3 * x + 2]


def figures_of(png):
    """Of the pixels that are not the backdrop, the corners' commonest colour: their share, mean, spread, how many are black,
    white, and at the border."""
    width, height, rows = pixels_of(png)
    corners = [rows[y][3 * x:3 * x + 3] for y in (0, height - 1) for x in (0, width - 1)]
    backdrop = collections.Counter(corners).most_common(1)[0][0]
    values, border = [], 0
    for y, row in enumerate(rows):
        for x in range(width):
            if max(abs(row[3 * x + i] - backdrop[i]) for i in range(3)) <= 2:
                continue
            values.append(luminance(row, x))
            border += x in (0, width - 1) or y in (0, height - 1)
    count = max(1, len(values))
    mean = sum(values) / count
    return {'share': len(values) / (width * height), 'mean': mean / 255,
            'spread': (sum((value - mean) ** 2 for value in values) / count) ** 0.5 / 255,
            'black': sum(value < 8 for value in values) / count, 'white': sum(value > 252 for value in values) / count,
            'border': border / (2 * (width + height))}


def words_of(figures):
    """What figures that are far off mean."""
    if figures['share'] < 0.01:
        return ['empty']
    limits = (('black', figures['black'] > 0.4 or figures['mean'] < 0.08), ('burnt', figures['white'] > 0.04),
              ('flat', figures['spread'] < 0.02), ('cut', 0.02 < figures['border'] < 0.98))
    return [word for word, so in limits if so]


def apart(first, second):
    """Mean difference of two pictures of one size, in codes; None where they are not."""
    a, b = pixels_of(first), pixels_of(second)
    if a[:2] != b[:2]:
        return None
    return sum(abs(x - y) for one, other in zip(a[2], b[2]) for x, y in zip(one, other)) / (3 * a[0] * a[1])


def image_of(png, said):
    if png is None:
        return f'<b>{html.escape(said)}</b>'
    return f'<img alt="" src="data:image/png;base64,{base64.b64encode(png).decode()}">'


def line_of(png, seconds):
    if png is None:
        return [], ''
    figures = figures_of(png)
    return words_of(figures), (f'{100 * figures["share"]:.0f} % of the picture, mean {figures["mean"]:.2f}, '
                               f'white {100 * figures["white"]:.1f} %, black {100 * figures["black"]:.0f} %, {seconds:.1f} s')


def figure_of(model, options, folder):
    """(HTML, name, words): one model, by one program or two."""
    name = os.path.splitext(os.path.basename(model))[0]
    pictures = [drawn(program, model, options, folder) for program in [options.program, *options.against]]
    png, seconds, said = pictures[0]
    words, line = line_of(png, seconds)
    words = words if png is not None else ['refused']
    if len(pictures) > 1 and png is not None and pictures[1][0] is not None:
        difference = apart(png, pictures[1][0])
        line += '; against: ' + line_of(*pictures[1][:2])[1] + (f'; {difference:.1f} codes apart' if difference is not None else '')
    shown = ''.join(image_of(picture, said) for picture, _, said in pictures)
    marked = f' <b>{", ".join(words)}</b>' if words else ''
    caption = f'{html.escape(name)}{marked}<br><span class="quiet">{html.escape(line)}</span>'
    return f'<figure>{shown}<figcaption>{caption}</figcaption></figure>', name, words


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('models', nargs='*')
    parser.add_argument('--program', default=os.path.join(ROOT, 'build/release/heliograph'))
    parser.add_argument('--against', action='append', default=[], metavar='PROGRAM')
    parser.add_argument('--size', default='240x180')
    parser.add_argument('--samples', type=int, default=8)
    parser.add_argument('--seconds', type=int, default=120, help='that one picture may take')
    parser.add_argument('--out', default=os.path.join(ROOT, 'out/looks/contact_sheet.html'))
    options = parser.parse_args()
    models = options.models or models_below(MODELS)
    if not models:
        sys.exit(f'contact_sheet.py: no model given and none below {MODELS}')
    figures, odd = [], 0
    with tempfile.TemporaryDirectory() as folder:
        for model in models:
            figure, name, words = figure_of(model, options, folder)
            figures.append(figure)
            odd += bool(words)
            print(f'{name:36} {", ".join(words)}', flush=True)
    width = (int(options.size.split('x')[0]) + 4) * (1 + len(options.against))
    os.makedirs(os.path.dirname(os.path.abspath(options.out)), exist_ok=True)
    with open(options.out, 'w', encoding='utf-8') as file:
        file.write(f'<!doctype html><meta charset="utf-8"><title>Models at defaults</title><style>{STYLE % (width, width)}</style>'
                   f'<main>{"".join(figures)}</main>')
    print(f'{len(models)} models, {odd} with a word; {os.path.relpath(options.out)}')


if __name__ == '__main__':
    main()
