"""Drives `runner motor-server` from Python: holds HOAP-2's posture and bends one joint by 0.1 rad.

Prints the last readings: time, angle of the joint, position of the base.
Usage: python client.py PORT JOINT"""

import math
import os
import socket
import struct
import sys

HEADER = struct.Struct("<4sHBBIIQQQd")
VERSION = 2
HELLO, WELCOME, CONTROL, SENSING, BYE, CONFIRM = 1, 2, 3, 4, 5, 6
BASE, LAST = 2, 8
sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
sock.settimeout(20)
sock.connect(("127.0.0.1", int(sys.argv[1])))
bent = int(sys.argv[2])
sent = 0


def send(kind, session, tick, time, body=b""):
    global sent
    sent += 1
    sock.send(HEADER.pack(b"stic", VERSION, kind, 0, HEADER.size + len(body), 0, session, sent, tick, time) + body)


nonce = int.from_bytes(os.urandom(8), "little") | 1
send(HELLO, nonce, 0, 0.0, bytes(32) + struct.pack("<d", 1000.0))
start, position, time, base = None, None, 0.0, ()
while True:
    packet = sock.recv(65536)
    _, _, kind, flags, _, _, session, _, tick, time = HEADER.unpack_from(packet)
    if kind == WELCOME:
        send(CONFIRM, session, 0, 0.0, struct.pack("<Q", nonce) + packet[104:136])
    if kind != SENSING:
        continue
    joints, soles = struct.unpack_from("<II", packet, 48)
    position = struct.unpack_from(f"<{joints}d", packet, 56)
    start = start or position
    if flags & BASE:
        base = struct.unpack_from("<3d", packet, 56 + 8 * (3 * joints + 10))
    if flags & LAST:
        send(BYE, session, tick, time)
        break
    target = list(start)
    target[bent] += 0.1 * (1 - math.cos(math.pi * min(time / 0.5, 1))) / 2
    rows = [target, [0.0] * joints, [0.0] * joints, [100.0] * joints, [1.0] * joints]
    body = struct.pack("<QI", tick + 1, joints) + bytes(joints) + b"".join(struct.pack(f"<{joints}d", *r) for r in rows)
    send(CONTROL, session, tick, time, body)
print(time, position[bent] - start[bent], *base)
