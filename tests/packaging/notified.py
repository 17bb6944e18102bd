#!/usr/bin/env python3
"""A service manager's ear: prints what is said to the socket of $NOTIFY_SOCKET. notified.py PATH"""
import os, socket, sys

ear = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
ear.bind(sys.argv[1])
os.chmod(sys.argv[1], 0o777)
while True:
    print(ear.recv(4096).decode(), flush=True)
