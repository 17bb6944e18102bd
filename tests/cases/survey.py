#!/usr/bin/env python3
"""What becomes of scene files: survey.py FOLDER... gives each .gltf, .glb and .obj below to `heliograph inspect`, and prints those
that are refused, each with why, then the extensions that were met: of how many files, and what is made of them.

survey.py [--program build/release/heliograph] [--all] FOLDER..."""
import argparse, collections, json, os, subprocess


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('folders', nargs='+')
    parser.add_argument('--program', default='build/release/heliograph')
    parser.add_argument('--all', action='store_true', help='a row for files that are drawn, too')
    options = parser.parse_args()
    extensions, drawn, refused = collections.defaultdict(set), 0, 0
    for folder in options.folders:
        for path in sorted(os.path.join(at, name) for at, _, names in os.walk(folder) for name in names):
            if not path.lower().endswith(('.gltf', '.glb', '.obj')):
                continue
            done = subprocess.run([options.program, 'inspect', path, '--json'], capture_output=True, timeout=300)
            shown = os.path.relpath(path, folder)
            if done.returncode != 0:
                refused += 1
                why = done.stderr.decode(errors='replace').strip().splitlines()[-1:] or [f'exit code {done.returncode}']
                print('refused  %-60s %s' % (shown, why[0].replace('heliograph: ', '').replace(path, '').lstrip(': ')[:140]))
                continue
            drawn += 1
            scene = json.loads(done.stdout)
            for row in scene['extensions']:
                extensions[row['name'], row['read'], row['note']].add(path)
            if options.all:
                print('drawn    %-60s %s triangles, %s warnings' % (shown, scene['triangles'], len(scene['warnings'])))
    for (name, read, note), files in sorted(extensions.items()):
        print('%-12s %-38s %4d files: %s' % ('read' if read else 'not read', name, len(files), note))
    print(f'{drawn} drawn, {refused} refused')


if __name__ == '__main__':
    main()
