"""Writes small ONNX files: the protocol buffers of the format, without a library for networks."""

import struct

FLOAT = 1


def _varint(number):
    out = bytearray()
    while number >= 0x80:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes(out + bytearray([number]))


def message(*fields):
    """Pairs of a field's number and its value: a whole number, bytes, a text or a list of these."""
    out = b""
    for field, value in fields:
        for item in value if isinstance(value, list) else [value]:
            if isinstance(item, int):
                out += _varint(field << 3) + _varint(item)
            else:
                data = item.encode() if isinstance(item, str) else item
                out += _varint(field << 3 | 2) + _varint(len(data)) + data
    return out


def value(name, width):
    """An input or output of any number of rows."""
    shape = message((1, [message((2, "batch")), message((1, width))]))
    return message((1, name), (2, message((1, message((1, FLOAT), (2, shape))))))


def constant(name, rows):
    """A matrix, or a vector given as a list of numbers."""
    dims = [len(rows), len(rows[0])] if isinstance(rows[0], list) else [len(rows)]
    numbers = [x for row in rows for x in (row if isinstance(row, list) else [row])]
    return message((1, dims), (2, FLOAT), (8, name), (9, struct.pack(f"<{len(numbers)}f", *numbers)))


def node(kind, inputs, output):
    """An operation."""
    return message((1, inputs), (2, output), (3, output), (4, kind))


def network(inputs, outputs, constants, nodes):
    """The bytes of a file."""
    graph = message((1, nodes), (2, "network"), (5, constants), (11, inputs), (12, outputs))
    return message((1, 8), (7, graph), (8, message((2, 17))))


def affine(weights, bias):
    """``actions = obs W + b``, W row by row."""
    return network(
        [value("obs", len(weights))],
        [value("actions", len(bias))],
        [constant("W", weights), constant("b", bias)],
        [node("Gemm", ["obs", "W", "b"], "actions")],
    )
