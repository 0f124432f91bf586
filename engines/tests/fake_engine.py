"""An engine for the tests: one box slides as in `slide-0`; settings make it fail in each way."""

import os
import signal
import time

import numpy

from stiction_engines.engine import BodyState, Engine, Failed, Settings, Simulation, Unsupported

SPEED, DECELERATION = 2.0, 0.5 * 9.81


class Slide(Simulation):
    """The closed form of a box that slides to rest."""

    def __init__(self, step):
        self.step, self.steps = step, 0

    @property
    def time(self):
        return self.steps * self.step

    def advance(self, steps):
        self.steps += steps

    def states(self):
        t = min(self.time, SPEED / DECELERATION)
        x, v = SPEED * t - DECELERATION * t * t / 2, SPEED - DECELERATION * t
        zero = numpy.zeros(3)
        return [
            BodyState(
                numpy.array([x, 0, 0.05]), numpy.array([1.0, 0, 0, 0]), numpy.array([v, 0, 0]), zero, [], []
            )
        ]


class Adapter(Engine):
    """The engine."""

    name = "fake"
    package = "fake"

    def version(self):
        return "1.0"

    def settings(self):
        names = [
            "works",
            "prints",
            "sleeps",
            "crashes",
            "exits",
            "fails",
            "lacks",
            "raises",
            "not-finite",
            "crashes-in-cost",
        ]
        return [Settings(name, name, steps=(0.01,)) for name in names]

    def simulation(self, case, settings, step):
        if settings.name == "prints":
            print('{"outcome": "printed"}', flush=True)
            os.write(1, b"{}\n")
            os.write(2, b"{}\n")
        elif settings.name == "sleeps":
            time.sleep(1000)
        elif settings.name == "crashes":
            os.write(2, b"assertion failed\n")
            os.kill(os.getpid(), signal.SIGSEGV)
        elif settings.name == "exits":
            os._exit(7)
        elif settings.name == "fails":
            raise Failed("too fast")
        elif settings.name == "lacks":
            raise Unsupported("no boxes")
        elif settings.name == "raises":
            raise ValueError("two\nlines")
        return Slide(step)

    def record(self, case, settings, step):
        series = super().record(case, settings, step)
        if settings.name == "not-finite":
            series.bodies["box"].linear_velocity[-1] = 1.0
        return series

    def cost(self, case, settings, step):
        if settings.name == "crashes-in-cost":
            os.kill(os.getpid(), signal.SIGSEGV)
        return 0.5 * step, round(case.duration / step)
