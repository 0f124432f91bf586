#!/usr/bin/env python3
"""Clones the task `balance` of HOAP-2 into a network, `hoap2-balance.onnx`.

The task with `control = "force"` is a function of the robot's state. The network learns it by
imitation: in each round it drives the robot for a share of the efforts, under random pushes, and the
efforts that the task commands in the visited states are added to the data. The network is

    efforts = tanh(observation W1 + b1) W2 + b2

with the observation of `hoap2-stands.toml`. Normalization of the data is part of the weights.

    python scenarios/policies/clone_balance.py [FILE]

takes 5 minutes and prints the share of pushes that the network survives. Made with NumPy 2.4.6, onnx
1.23.2, Python 3.11 and this repository's package `stiction`, with the seed below. The weights depend
on the order of sums in NumPy's matrix products, so their last digits may differ.
"""

import sys
from pathlib import Path

import numpy as np
import onnx
import stiction
from onnx import TensorProto, helper, numpy_helper

SEED = 28
RATE = 500.0  # Hz
HIDDEN = 64
ROUNDS = 12
RUNS = 14  # of a round
STEPS = 2000  # of the optimizer in each round, ten times as many in the last one
BATCH = 512
UPRIGHT = -0.94  # cosine of the greatest tilt of the data
LIMIT = 5.0  # of normalized efforts, in standard deviations
HERE = Path(__file__).resolve().parent


def scenario(push, task, duration=4.0):
    """HOAP-2, pushed at its chest for 0.1 s."""
    start, force = push
    return {
        "duration": duration,
        "robot": {"model": HERE.parents[1] / "robots" / "hoap2" / "hoap2.toml"},
        "contact": {"velocity_tolerance": 0.02},
        "integrator": {"method": "semi-implicit", "step": 1e-3},
        "control": {"rate": RATE},
        "log": {"rate": 0.0},
        "force": [
            {"type": "push", "link": "torso", "point": [0, 0, 0.05], "force": force, "start": start, "duration": 0.1}
        ],
        "stop": {"fallen": {"below": 0.2}},
        "task": task,
    }


def draw_push(random, greatest):
    """A horizontal push in any direction, up to `greatest` newtons."""
    angle, size = random.uniform(0.0, 2.0 * np.pi), greatest * np.sqrt(random.uniform())
    return random.uniform(0.2, 1.5), [size * np.cos(angle), size * np.sin(angle), 0.0]


def observe(context, home):
    """The observation of `hoap2-stands.toml`: its terms in order, without scales."""
    x, y, z, w = context.base_orientation
    turn = np.array(  # world from base
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    return np.concatenate(
        [
            -turn[2],
            turn.T @ context.base_linear_velocity,
            turn.T @ context.base_angular_velocity,
            context.q - home,
            context.qd,
        ]
    )


class Network:
    """Two layers, for normalized inputs and outputs."""

    def __init__(self, random, inputs, outputs):
        self.weights = [
            random.normal(0.0, 1.0 / np.sqrt(inputs), (inputs, HIDDEN)),
            np.zeros(HIDDEN),
            random.normal(0.0, 1.0 / np.sqrt(HIDDEN), (HIDDEN, outputs)),
            np.zeros(outputs),
        ]
        self.moments = [[np.zeros_like(w), np.zeros_like(w)] for w in self.weights]
        self.steps = 0

    def __call__(self, x):
        w1, b1, w2, b2 = self.weights
        y = (x - self.mean) / self.scale
        return np.tanh(y @ w1 + b1) @ w2 * self.out_scale + b2 * self.out_scale + self.out_mean

    def normalize(self, x, y):
        self.mean, self.scale = x.mean(axis=0), x.std(axis=0) + 1e-3
        self.out_mean, self.out_scale = y.mean(axis=0), y.std(axis=0) + 1e-4

    def fit(self, random, x, y, steps, rate=3e-3):
        """Adam on the mean square of the normalized error; returns the last one of a batch."""
        x, y = (x - self.mean) / self.scale, (y - self.out_mean) / self.out_scale
        y = y.clip(-LIMIT, LIMIT)
        for step in range(steps):
            pick = random.integers(0, len(x), BATCH)
            w1, b1, w2, b2 = self.weights
            h = np.tanh(x[pick] @ w1 + b1)
            error = h @ w2 + b2 - y[pick]
            back = (error @ w2.T) * (1.0 - h * h)
            slopes = [x[pick].T @ back, back.sum(axis=0), h.T @ error, error.sum(axis=0)]
            self.steps += 1
            size = rate * 0.5 * (1.0 + np.cos(np.pi * step / steps))
            for w, (first, second), slope in zip(self.weights, self.moments, slopes):
                slope = slope / BATCH
                first += 0.1 * (slope - first)
                second += 0.001 * (slope * slope - second)
                fixed = first / (1.0 - 0.9**self.steps), second / (1.0 - 0.999**self.steps)
                w -= size * fixed[0] / (np.sqrt(fixed[1]) + 1e-8)
        return float(np.mean(error**2))

    def folded(self):
        """The weights for observations and efforts in SI units, in single precision."""
        w1, b1, w2, b2 = self.weights
        first = w1 / self.scale[:, None]
        weights = [first, b1 - self.mean @ first, w2 * self.out_scale, b2 * self.out_scale + self.out_mean]
        return [w.astype(np.float32) for w in weights]


def visit(network, share, push, data):
    """Runs the task while the network has a share of the efforts; returns whether the robot stands."""

    def drive(context, command):
        x = observe(context, home)
        # A falling robot is beyond what the task can do.
        if x[2] < UPRIGHT:
            data.append((x, command.effort.copy()))
        if network is not None:
            command.effort[:] = share * network(x) + (1.0 - share) * command.effort

    values = scenario(push, [{"type": "balance", "control": "force"}])
    simulation = stiction.Simulation(values, tasks=[stiction.Task(drive)])
    home = simulation.state.q.copy()
    try:
        return simulation.run() == "passed"
    except stiction.RunError:
        return False


def save(network, path):
    """Writes the ONNX file."""
    w1, b1, w2, b2 = weights = network.folded()
    names = ["W1", "b1", "W2", "b2"]
    graph = helper.make_graph(
        [
            helper.make_node("Gemm", ["observation", "W1", "b1"], ["sum"]),
            helper.make_node("Tanh", ["sum"], ["hidden"]),
            helper.make_node("Gemm", ["hidden", "W2", "b2"], ["efforts"]),
        ],
        "hoap2-balance",
        [helper.make_tensor_value_info("observation", TensorProto.FLOAT, ["batch", len(w1)])],
        [helper.make_tensor_value_info("efforts", TensorProto.FLOAT, ["batch", len(b2)])],
        [numpy_helper.from_array(w, name) for w, name in zip(weights, names)],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], producer_name="clone_balance.py")
    model.ir_version = 8
    onnx.checker.check_model(model)
    onnx.save(model, path)


def main():
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "hoap2-balance.onnx"
    random = np.random.default_rng(SEED)
    data, network = [], None
    for number in range(ROUNDS):
        # From the task alone to the network alone.
        share = min(1.0, number / (ROUNDS - 5))
        stood = sum(visit(network, share, draw_push(random, 26.0), data) for _ in range(RUNS))
        x, y = (np.array(part) for part in zip(*data))
        last = number == ROUNDS - 1
        # The first rounds do not show the whole range of states.
        if number <= 4 or last:
            network = Network(random, x.shape[1], y.shape[1])
            network.normalize(x, y)
        error = network.fit(random, x, y, 10 * STEPS if last else STEPS)
        print(f"round {number}: share {share:.2f}, {stood} of {RUNS} stood, {len(x)} states, error {error:.2e}", flush=True)
    save(network, path)
    stood = [visit(network, 1.0, draw_push(random, 25.0), []) for _ in range(50)]
    task = [visit(None, 0.0, draw_push(random, 25.0), []) for _ in range(50)]
    print(f"pushes up to 25 N: the network stands after {sum(stood)} of 50, the task after {sum(task)} of 50 others")


if __name__ == "__main__":
    main()
