#!/usr/bin/env python3
"""Writes height_fields.json: points at which MuJoCo's rays meet the height fields of tests/scenario/height_fields.

Run by hand, in an environment with `mujoco` (4.0.0) and `numpy`:

    python tests/oracles/make_height_fields.py

It also writes the pictures and the binary file that fields.xml names.
"""

import json
import struct
import zlib
from pathlib import Path

import mujoco
import numpy as np

HERE = Path(__file__).resolve().parent
FOLDER = HERE.parent / "scenario/height_fields"
RAYS = 60


def main():
    random = np.random.default_rng(7)
    (FOLDER / "grey.png").write_bytes(picture(random.integers(0, 65536, (5, 4)), 16, 0))
    (FOLDER / "red.png").write_bytes(picture(random.integers(0, 256, (3, 6, 3)), 8, 2))
    (FOLDER / "raw.bin").write_bytes(struct.pack("<ii", 4, 3) + random.uniform(-2, 5, 12).astype("<f4").tobytes())
    model = mujoco.MjModel.from_xml_path(str(FOLDER / "fields.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    fields = {model.geom(i).name: hits(model, data, i, random) for i in range(model.ngeom)}
    oracle = {"versions": {"mujoco": mujoco.__version__, "numpy": np.__version__}, "fields": fields}
    path = HERE / "height_fields.json"
    path.write_text(json.dumps(oracle, separators=(",", ":")) + "\n")
    print(f"{path.name}: {path.stat().st_size} bytes")


def picture(values, depth, colour):
    """A PNG without filters: greyscale (0) or RGB (2)."""
    lines = b"".join(b"\0" + line.astype(">u2" if depth == 16 else np.uint8).tobytes() for line in values)
    rows, columns = values.shape[:2]
    header = struct.pack(">IIBBBBB", columns, rows, depth, colour, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(lines)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
        for kind, content in chunks
    )


def hits(model, data, geom, random):
    """Points of a field that vertical rays meet."""
    half = model.hfield_size[model.geom_dataid[geom], :2]
    points = []
    for _ in range(RAYS):
        # Away from the border, whose walls a ray meets where the field is tilted.
        on_field = data.geom_xmat[geom].reshape(3, 3) @ [*(0.7 * random.uniform(-half, half)), 0]
        start = data.geom_xpos[geom] + on_field + [0, 0, 10]
        met = np.array([-1], dtype=np.int32)
        distance = mujoco.mj_ray(model, data, start, np.array([0, 0, -1.0]), None, 1, -1, met)
        if met[0] == geom:
            points.append([start[0], start[1], start[2] - distance])
    assert len(points) == RAYS
    return points


if __name__ == "__main__":
    main()
