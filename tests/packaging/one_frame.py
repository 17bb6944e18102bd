#!/usr/bin/env python3
"""/healthz and one frame over WebSocket of a server that runs. one_frame.py URL [--page]; exit code 1 where one is missing."""
import os, sys
from urllib.parse import urlsplit

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '../operations'))
from support import Viewer, http

url = urlsplit(sys.argv[1])
status, _, body = http(url.port, '/healthz')
if status != 200:
    sys.exit('/healthz: %d %s' % (status, body))
if '--page' in sys.argv:
    status, _, body = http(url.port, '/')
    if status != 200 or '<script' not in body:
        sys.exit('/: %d %s' % (status, body[:200]))
viewer = Viewer(url.port)
if viewer.status != 101:
    sys.exit('/ws: %d' % viewer.status)
viewer.read(60, lambda: viewer.inputs)
if not viewer.inputs:
    sys.exit('no frame; said: %s' % viewer.texts[-3:])
print('frame with input %d' % viewer.inputs[-1])
