"""A bar that is pulled: a file for `rbs run`, which the tests of the command line copy and run."""

from __future__ import annotations

import math
import os
import signal
import time

import numpy as np

import rbs_core as rbs
from rbs_plugins import BondBased, BoundaryDomain, CSVExporter, KineticEnergy, VelocityVerlet
from rbs_plugins.fields import density, displacement, kinetic_energy


class Slow(rbs.Measure):
    """Takes its time, and presses Ctrl-C in step 3."""

    def __init__(self, part, pause, keys):
        super().__init__(part)
        self.pause, self.keys_pressed = pause, keys

    def apply(self, clock):
        time.sleep(self.pause)
        for _ in range(self.keys_pressed if clock.step == 3 else 0):
            os.kill(os.getpid(), signal.SIGINT)


def scene(n=20, speed=1.0, pause=0.0, keys=0, saved=4, name="", region=None, out="nowhere"):
    bar = rbs.Part("bar", rbs.Box(size=1.0, center=0.5)).discretize(1.0 / n, area=1e-4).connect(horizon=3.0 / n)
    bar[density] = 8000.0
    ends = [
        BoundaryDomain(bar, lambda X: X[:, 0] < 3.0 / n, velocity=0.0),
        BoundaryDomain(bar, lambda X: X[:, 0] > 1.0 - 3.0 / n, velocity=speed),
    ]
    return rbs.Analysis(
        [
            *VelocityVerlet(bar).step([BondBased(bar, E=192e9)], ends),
            KineticEnergy(bar),
            CSVExporter(bar, [kinetic_energy], f"{out}/history.csv"),
            *([Slow(bar, pause, keys)] if pause or keys else []),
            *([rbs.Checkpoint(f"{out}/checkpoint.npz", when=rbs.every(saved))] if saved else []),
        ],
        steps=20,
        title="pulled bar",
    )


def measure(analysis):
    bar = analysis.parts[0]
    return {
        "nodes": len(bar),
        "pulled_m": float(bar[displacement][-1, 0]),
        "kinetic_J": np.float64(bar[kinetic_energy]),
        "never": math.inf,
        "unknown": np.float32("nan"),
        "path": np.array([[1.0, -np.inf], [0.5, 2.0]]),
        "more": {"list": [1, (2.0, math.nan)], 3: None},
        "good": np.bool_(True),
    }
