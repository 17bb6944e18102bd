#!/usr/bin/env python3
"""A viewer in sixty lines, written from docs/reference/protocol.md: circles a scene, saves frames, prints what it measured.

orbit.py [URL] [--scene NAME] [--size WxH] [--seconds S] [--save FOLDER]; needs python3-websockets. Prints one line of JSON
and exits with 1 when no picture came, one was no JPEG, or the last picture did not show the last input."""
import argparse, asyncio, json, math, pathlib, statistics, struct, sys, time
import websockets

HEADER = struct.Struct("<2sBBHBBIIIHHHHIfIIIIIII")  # 64 bytes


def turned(camera, centre, angle):
    """The camera moved around the vertical axis through `centre`, looking at it as before."""
    c, s = math.cos(angle), math.sin(angle)
    spin = lambda v: [c * v[0] + s * v[2], v[1], c * v[2] - s * v[0]]
    from_centre = spin([p - q for p, q in zip(camera["position"], centre)])
    return {**camera, "position": [p + q for p, q in zip(from_centre, centre)], "forward": spin(camera["forward"]), "up": spin(camera["up"])}


async def watch(o):
    width, height = map(int, o.size.split("x"))
    sent, delays, renders, sizes, shown, bad, ready, begun = {}, [], [], [], 0, 0, None, None
    async with websockets.connect(o.url, subprotocols=["heliograph.v1"], max_size=None) as socket:
        async def say(**message): await socket.send(json.dumps(message))
        await say(type="resolution", width=width, height=height, inputId=1)
        if o.scene: await say(type="scene", name=o.scene)
        wanted, last, deadline = 1, 0, time.monotonic() + 120
        while time.monotonic() < deadline:
            message = await asyncio.wait_for(socket.recv(), 120)
            if isinstance(message, str):
                told = json.loads(message)
                if told["type"] == "error" or told.get("state") == "failed": sys.exit(f"the server says: {told}")
                if told["type"] == "scene" and told.get("state") == "ready" and (not o.scene or told["name"] == o.scene): ready = told
                continue
            magic, kind, codec, length, flags, _, frame, shown, *rest = HEADER.unpack(message[:64])
            picture, now = message[length:], time.monotonic()
            bad += magic != b"HG" or codec != 0 or picture[:2] != b"\xff\xd8"
            delay = (now - sent[shown]) * 1e3 if shown in sent else None
            await say(type="ack", frameId=frame, presentedMs=delay)
            if begun:
                delays += [delay] if delay is not None and shown > last else []
                renders.append(rest[7] / 1e3)
                sizes.append(len(picture))
                if o.save: pathlib.Path(o.save, f"frame{len(sizes):04d}.jpg").write_bytes(picture)
                if now - begun > o.seconds and shown == wanted: break
            elif ready: begun, deadline = now, now + o.seconds + 10
            last = shown
            if begun and now - begun < o.seconds:
                wanted += 1
                camera = turned(ready["camera"], [(a + b) / 2 for a, b in zip(ready["bounds"]["low"], ready["bounds"]["high"])], 0.2 * (now - begun))
                sent[wanted] = time.monotonic()
                await say(type="camera", inputId=wanted, moving=now - begun < o.seconds, **camera)
    q = lambda v, p: round(sorted(v)[min(len(v) - 1, int(p * len(v)))], 2) if v else None
    print(json.dumps({"pictures": len(sizes), "per_second": round(len(sizes) / o.seconds, 1), "size": o.size,
                      "motion_to_photon_ms": {"p50": q(delays, 0.5), "p95": q(delays, 0.95)}, "render_ms": q(renders, 0.5),
                      "bytes": round(statistics.mean(sizes)) if sizes else 0, "bad": bad, "last_input_shown": shown == wanted}))
    return 0 if sizes and not bad and shown == wanted else 1


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("url", nargs="?", default="ws://127.0.0.1:8080/ws")
    for name, default in (("scene", ""), ("size", "640x360"), ("seconds", 5.0), ("save", "")):
        options.add_argument("--" + name, default=default, type=type(default))
    sys.exit(asyncio.run(watch(options.parse_args())))
