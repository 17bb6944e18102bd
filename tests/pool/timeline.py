"""The frame in which a node died, as the broker saw it: a table and a picture (SVG) of who had which batch when."""

import signal
import struct
import time

from broker import BATCH, BATCH_END, HEADER, NODE_BEAT, TILES, Stranger, kind_of, peer_of

WIDTH, LANE, LEFT = 900, 34, 110  # pixels
PICTURE = ["--size", "640x360", "--samples", "1"]


def batch_of(data, after=0):
    return struct.unpack_from("<Q", data, HEADER + after)[0]


class Listener:
    """What nodes are told and say, with the time of each in seconds."""

    def __init__(self):
        self.names = {}  # of peers
        self.batches = {}  # number: [node, out, last result or end, ended]

    def hear(self, now, subject, data):
        kind = kind_of(data)
        if kind == NODE_BEAT:
            length = struct.unpack_from("<H", data, HEADER + 40)[0]
            self.names[peer_of(data)] = data[HEADER + 42:HEADER + 42 + length].decode()
        if kind == BATCH:
            self.batches[batch_of(data, 8)] = [self.names.get(subject.rsplit(".", 1)[1], "?"), now, now, False]
        if kind in (TILES, BATCH_END) and batch_of(data) in self.batches:
            batch = self.batches[batch_of(data)]
            batch[2], batch[3] = now, kind == BATCH_END


def table(listener, begin, died, end, victim):
    rows = []
    for number, (node, out, last, ended) in sorted(listener.batches.items(), key=lambda item: item[1][1]):
        if last < died - 0.3 or out > end:
            continue
        what = f"done at {1e3 * (last - begin):.0f}" if ended else f"last result at {1e3 * (last - begin):.0f}, no end"
        rows.append((out, f"{node}: batch {number}, {what}"))
    rows += [(died, f"kill -9 of {victim}"), (end, "the picture is complete")]
    return [f"  {1e3 * (at - begin):6.0f} ms  {text}" for at, text in sorted(rows)]


def drawing(listener, begin, died, end, victim):
    lanes = sorted({batch[0] for batch in listener.batches.values()})
    def across(at):
        return LEFT + (WIDTH - LEFT - 10) * (at - begin) / (end - begin)

    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{LANE * len(lanes) + 40}" '
             'font-family="sans-serif" font-size="12">']
    for lane, node in enumerate(lanes):
        parts.append(f'<text x="4" y="{LANE * lane + 22}">{node}</text>')
        rows = [batch for batch in sorted(listener.batches.values(), key=lambda b: b[1]) if batch[0] == node]
        for index, (_, out, last, ended) in enumerate(rows):
            colour = "#4a7" if ended else "#c43"
            parts.append(f'<rect x="{across(out):.1f}" y="{LANE * lane + 6 + 12 * (index % 2)}" height="11" '
                         f'width="{max(across(last) - across(out), 1):.1f}" fill="{colour}" stroke="#fff"/>')
    bottom = LANE * len(lanes) + 8
    parts.append(f'<line x1="{across(died):.1f}" x2="{across(died):.1f}" y1="0" y2="{bottom}" stroke="#c43"/>')
    parts.append(f'<text x="{across(died) + 4:.1f}" y="{bottom + 12}" fill="#c43">kill -9 of {victim}</text>')
    parts.append(f'<text x="{LEFT}" y="{bottom + 26}">{1e3 * (end - begin):.0f} ms in all; green: answered, red: not</text></svg>')
    return "\n".join(parts)


def frame(pool, path):
    """A picture of one sample by two nodes, of which one is killed once it has answered a batch."""
    for name in ("one", "two"):
        if name not in pool.nodes:
            pool.node(name)
    line = Stranger(pool.broker)
    line.subscribe("heliograph.pool.>", 1)
    out = pool.path("timeline.exr")
    process = pool.start(out, nodes=2, picture=PICTURE)
    listener, died = Listener(), None
    for subject, data in line.messages(20.0):
        now = time.monotonic()
        listener.hear(now, subject, data)
        answered = [batch for batch in listener.batches.values() if batch[0] == "two" and batch[3]]
        waits = [batch for batch in listener.batches.values() if batch[0] == "two" and not batch[3]]
        if died is None and answered and waits:
            pool.end_node("two", signal.SIGKILL)
            died = time.monotonic()
        if process.poll() is not None:
            break
    line.close()
    result, _ = pool.result(process)
    pool.same("the frame in which a node died", out, result)
    pool.check("it died in the frame", died is not None)
    if died is None:
        return
    begin = min(batch[1] for batch in listener.batches.values())
    end = max(batch[2] for batch in listener.batches.values())
    print("the frame in which a node died:", *table(listener, begin, died, end, "two"), sep="\n")
    with open(path, "w", encoding="utf-8") as file:
        file.write(drawing(listener, begin, died, end, "two"))
