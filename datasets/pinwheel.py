#!/usr/bin/env python3
"""Writes pinwheel.obj: a toy windmill of eight folded blades about the z axis, its front towards -z, with colours."""
import math

BLADES, STEPS, RADIUS = 8, 12, 1.0
COLORS = [(0.95, 0.25, 0.20), (0.98, 0.75, 0.15), (0.20, 0.65, 0.90), (0.55, 0.80, 0.25)]

vertices, faces = [], []


def add(x, y, z, color):
    vertices.append((x, y, z, *color))
    return len(vertices)


for blade in range(BLADES):
    start = 2 * math.pi * blade / BLADES
    color = COLORS[blade % len(COLORS)]
    dark = tuple(0.55 * c for c in color)
    rows = []
    for i in range(STEPS + 1):
        # From the straight edge of a sheet to its corner, which is folded back to the hub.
        s = i / STEPS
        turn = start + s * 2 * math.pi / BLADES
        lift = 0.34 * math.sin(math.pi * s)
        reach = RADIUS * (1 - 0.25 * s)
        tip = add(reach * math.cos(turn), reach * math.sin(turn), -lift, color)
        root = add(0.08 * math.cos(turn), 0.08 * math.sin(turn), -0.5 * lift, dark)
        rows.append((tip, root))
    for (a, b), (c, d) in zip(rows, rows[1:]):
        faces += [(a, b, c), (c, b, d)]

hub = add(0, 0, -0.22, (0.9, 0.9, 0.85))
ring = [add(0.1 * math.cos(2 * math.pi * i / 16), 0.1 * math.sin(2 * math.pi * i / 16), -0.16, (0.5, 0.5, 0.5))
        for i in range(16)]
faces += [(hub, ring[(i + 1) % 16], ring[i]) for i in range(16)]

with open("pinwheel.obj", "w", encoding="ascii") as file:
    file.write("# Written by pinwheel.py\n")
    for vertex in vertices:
        file.write("v " + " ".join(f"{value:.4f}" for value in vertex) + "\n")
    for face in faces:
        file.write("f " + " ".join(map(str, face)) + "\n")
