#!/usr/bin/env python3
"""Files from strangers: every file of a folder, and mutations of models, go to `heliograph inspect`, each in a process of its
own. None may crash, none may make a sanitizer speak, none may take over 5 s of processor time or over 1 GiB. Prints a table.

hostile.py [--program P] [--folder ../shared/scenes/invalid] [--mutations 1000] [--seed 1] [--jobs 1] [--keep FOLDER]
The program is best one built with sanitizers (build/asan). What broke is copied to --keep. Exit code 1: something broke."""
import argparse, collections, concurrent.futures, json, os, random, resource, shutil, signal, struct, subprocess, sys, tempfile, time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
MODELS = ('.gltf', '.glb', '.obj')
SECONDS, MEMORY_KIB = 5.0, 1 << 20
REPORTS = ('Sanitizer', 'runtime error:', 'Assertion', 'terminate called')
NUMBERS = ['0', '-1', '1', '255', '65536', '2147483647', '2147483648', '4294967295', '4294967296', '9223372036854775807',
           '18446744073709551616', '1e19', '-1e19', '1e38', '1e39', '1e308', '1e-19', '1e-45', '0.5', '-0.0', '1e400']
Outcome = collections.namedtuple('Outcome', 'code seconds kib words')


def inspect(program, path):
    """Exit code (negative: the signal), processor seconds, most memory in KiB, standard error."""
    with tempfile.TemporaryFile() as err:
        process = subprocess.Popen([program, 'inspect', path, '--json'], stdout=subprocess.DEVNULL, stderr=err,
                                   stdin=subprocess.DEVNULL, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (30, 30)),
                                   env={**os.environ, 'UBSAN_OPTIONS': 'print_stacktrace=1', 'HELIOGRAPH_CACHE': '',
                                        'ASAN_OPTIONS': 'detect_leaks=0:allocator_may_return_null=0:quarantine_size_mb=16'})
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        err.seek(0)
        return Outcome(process.returncode, usage.ru_utime + usage.ru_stime, usage.ru_maxrss, err.read())


def broken(outcome):
    """What is wrong with it; nothing where it is well."""
    words = outcome.words.decode('utf-8', 'replace')
    if any(report in words for report in REPORTS):
        return 'report'
    if outcome.code < 0 or outcome.code not in (0, 2):
        return 'crash'
    if outcome.seconds > SECONDS:
        return 'slow'
    if outcome.kib > MEMORY_KIB:
        return 'large'
    if outcome.code == 2 and not words.strip():
        return 'silent'
    try:
        outcome.words.decode('utf-8')
    except UnicodeDecodeError:
        return 'not UTF-8'
    return ''


def places(value, at=()):
    """Every place in a JSON value, as keys from the top."""
    children = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, child in children:
        yield at + (key,)
        yield from places(child, at + (key,))


def mutate_json(text, rng):
    try:
        root = json.loads(text)
    except (ValueError, RecursionError):
        return mutate_bytes(text.encode('utf-8', 'surrogateescape'), rng)
    for _ in range(rng.choice((1, 1, 2, 4))):
        all_places = list(places(root))
        if not all_places:
            break
        place = rng.choice(all_places)
        holder = root
        for key in place[:-1]:
            holder = holder[key]
        kind, old = rng.randrange(6), holder[place[-1]]
        if kind == 0:
            del holder[place[-1]]
        elif kind == 1:
            holder[place[-1]] = rng.choice((None, True, '', [], {}, 'a' * 300, [[[]]], '\u0000', '../../x'))
        elif kind == 2 and isinstance(holder, list):
            holder.extend([old] * rng.choice((1, 3, 40)))
        elif kind == 3:
            other = root
            for key in rng.choice(all_places):
                try:
                    other = other[key]
                except (KeyError, IndexError, TypeError):
                    break
            holder[place[-1]] = json.loads(json.dumps(other))  # a copy: it may hold the place itself
        else:
            holder[place[-1]] = '@@%s@@' % rng.choice(NUMBERS)
    out = json.dumps(root)
    return out.replace('"@@', '').replace('@@"', '').encode('utf-8', 'surrogateescape')


def mutate_glb(data, rng):
    if rng.random() < 0.6 and len(data) > 20 and data[16:20] == b'JSON':
        size = struct.unpack_from('<I', data, 12)[0]
        text = mutate_json(data[20:20 + size].decode('utf-8', 'replace'), rng)
        text += b' ' * (-len(text) % 4)
        rest = data[20 + size:]
        total = 20 + len(text) + len(rest)
        return struct.pack('<4sIII4s', b'glTF', 2, total, len(text), b'JSON') + text + rest
    return mutate_bytes(data, rng)


def mutate_bytes(data, rng):
    data = bytearray(data)
    for _ in range(rng.choice((1, 2, 8, 32))):
        if not data:
            break
        at, kind = rng.randrange(len(data)), rng.randrange(6)
        if kind == 0:
            data[at] ^= 1 << rng.randrange(8)
        elif kind == 1:
            data[at] = rng.choice((0, 0x7f, 0x80, 0xff, rng.randrange(256)))
        elif kind == 2:
            del data[at:at + rng.randrange(1, 64)]
        elif kind == 3:
            data[at:at] = data[at:at + rng.randrange(1, 64)] * rng.choice((1, 2, 16))
        elif kind == 4:
            data[at:at + 4] = struct.pack('<I', rng.choice((0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x7f800000, 0x7fc00000)))
        elif rng.random() < 0.3:
            del data[at:]
        else:
            data[at:at + rng.randrange(8)] = rng.choice(NUMBERS).encode()
    return bytes(data)


def mutate(path, data, rng):
    if path.endswith('.gltf') and rng.random() < 0.7:
        return mutate_json(data.decode('utf-8', 'replace'), rng)
    return mutate_glb(data, rng) if path.endswith('.glb') else mutate_bytes(data, rng)


def models_of(folders, most_bytes=200_000):
    found = []
    for folder in folders:
        for at, _, names in sorted(os.walk(folder)):
            found += [os.path.join(at, n) for n in sorted(names) if n.lower().endswith(MODELS)]
    return [f for f in found if os.path.getsize(f) <= most_bytes]


def mutated(index, models, seed, folder):
    """A folder that has the model's neighbours, and in their midst the mutated model or a mutated neighbour."""
    rng = random.Random(seed * 1_000_003 + index)
    source = rng.choice(models)
    place = os.path.join(folder, str(index))
    os.mkdir(place)
    near = os.path.dirname(source)
    neighbours = [n for n in os.listdir(near) if os.path.isfile(os.path.join(near, n)) and n != os.path.basename(source)][:40]
    for name in neighbours:
        os.symlink(os.path.join(os.path.abspath(near), name), os.path.join(place, name))
    target = os.path.join(place, os.path.basename(source))
    changed = target
    small = [n for n in neighbours if os.path.getsize(os.path.join(near, n)) < 1 << 20 and not n.lower().endswith(MODELS)]
    if small and rng.random() < 0.3:  # its buffer, its picture, its materials
        changed = os.path.join(place, rng.choice(small))
        os.remove(changed)
        shutil.copyfile(source, target)
        source = os.path.join(near, os.path.basename(changed))
    with open(source, 'rb') as f:
        data = f.read()
    with open(changed, 'wb') as f:
        f.write(mutate(changed, data, rng))
    return target


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('--program', default=os.environ.get('HELIOGRAPH', os.path.join(ROOT, 'build/asan/heliograph')))
    parser.add_argument('--folder', action='append', help='may be given several times')
    parser.add_argument('--mutations', type=int, default=1000)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--jobs', type=int, default=1)
    parser.add_argument('--keep', default=os.path.join(ROOT, 'out/hostile'))
    options = parser.parse_args()
    folders = options.folder or [os.path.join(ROOT, '../shared/scenes/invalid')]
    scratch = tempfile.mkdtemp(prefix='heliograph-hostile-')
    rows = collections.defaultdict(lambda: collections.Counter())
    slowest, largest = collections.Counter(), collections.Counter()
    files = [os.path.join(at, n) for f in folders for at, _, names in sorted(os.walk(f)) for n in sorted(names)]
    models = models_of(folders)
    if not files or (options.mutations and not models):
        sys.exit('no files in ' + ' '.join(folders))

    def one(job):
        row, path = job if isinstance(job, tuple) else ('mutations', mutated(job, models, options.seed, scratch))
        outcome = inspect(options.program, path)
        fault = broken(outcome)
        if fault:
            print('%s: %s, exit code %d, %.1f s, %d MiB: %s' % (
                path, fault, outcome.code, outcome.seconds, outcome.kib >> 10, outcome.words.decode('utf-8', 'replace')[-300:]),
                flush=True)
            kept = os.path.join(options.keep, '%s-%s' % (fault.replace(' ', '-'), os.path.basename(os.path.dirname(path))))
            shutil.copytree(os.path.dirname(path), kept, dirs_exist_ok=True) if row == 'mutations' else None
        if row == 'mutations':
            shutil.rmtree(os.path.dirname(path), ignore_errors=True)
        return row, fault or ('read' if outcome.code == 0 else 'refused'), outcome

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for row, what, outcome in pool.map(one, [('files', f) for f in files] + list(range(options.mutations))):
            rows[row][what] += 1
            slowest[row] = max(slowest[row], outcome.seconds)
            largest[row] = max(largest[row], outcome.kib)
    shutil.rmtree(scratch, ignore_errors=True)
    print('| inputs | count | read | refused | crashes | reports | over 5 s | over 1 GiB | no words | slowest | largest |')
    print('| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |')
    for row, counts in rows.items():
        print('| %s | %d | %d | %d | %d | %d | %d | %d | %d | %.2f s | %d MiB |' % (
            row, counts.total(), counts['read'], counts['refused'], counts['crash'], counts['report'], counts['slow'],
            counts['large'], counts['silent'] + counts['not UTF-8'], slowest[row], largest[row] >> 10))
    failed = sum(counts.total() - counts['read'] - counts['refused'] for counts in rows.values())
    passed = sum(counts['read'] + counts['refused'] for counts in rows.values())
    print('%d passed, %d failed' % (passed, failed))
    sys.exit(1 if failed else 0)


if __name__ == '__main__':
    main()
