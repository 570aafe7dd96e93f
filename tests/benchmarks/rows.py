"""One row of the benchmark, in a process of its own: `python rows.py ROW ARGUMENTS`; prints its figures as JSON.

Nothing here asks for more than the public interface and, for the loop over bonds alone, `force._loops`.
"""

from __future__ import annotations

import json
import os
import resource
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import numpy as np

import rbs_core as rbs

SPACING, RATIO = 1e-4, 3.015  # m; horizon over spacing
DIMENSION = {"bar": 1, "plate": 2, "cube": 3}
Figures = dict[str, float]


def body(
    shape: tuple[int, ...], storage: str | None = None, precision: str = "double", name: str = "part"
) -> tuple[rbs.Part, float, float]:
    """A connected part of a regular grid; seconds of the first search, which may compile, and of one more."""
    from rbs_plugins.fields import density

    part = rbs.Part(name, rbs.Box(size=[n * SPACING for n in shape]), precision=precision).discretize(SPACING)
    seconds = []
    for _ in range(2 if len(part) <= 300_000 else 1):
        begin = time.perf_counter()
        part.connect(RATIO * SPACING, storage=storage)
        seconds.append(time.perf_counter() - begin)
    part[density] = 8000.0
    return part, seconds[0], seconds[-1]


def brittle(part: rbs.Part, model: str = "bond-based") -> Any:
    """The force that is measured: bonds may break, none does, and nothing is skipped."""
    from rbs_plugins import BondBased, Correspondence, CriticalStretch, OrdinaryStateBased
    from rbs_plugins.constitutive.stress import saint_venant_kirchhoff

    steel = {"E": 192e9, "fracture": CriticalStretch(0.04472)}
    active = False if part.bonds.storage == "lattice" else None
    if model == "correspondence":
        plane = {"plane": "strain"} if part.dimension == 2 else {}
        return Correspondence(part, saint_venant_kirchhoff, nu=0.3, **steel, **plane)
    return (
        OrdinaryStateBased(part, nu=0.2, active=active, **steel)
        if model == "ordinary"
        else BondBased(part, active=active, **steel)
    )


def shake(part: rbs.Part) -> None:
    """Displacements of a thousandth of the spacing."""
    from rbs_plugins.fields import displacement

    part[displacement] = 1e-3 * SPACING * np.random.default_rng(0).standard_normal(part.positions.shape)


def of_force(force: Any, repeats: int, figures: Figures) -> None:
    """Adds best, median and largest seconds of the loop over bonds, for one thread and for all."""
    import numba
    from machine import sample

    for threads in sorted({1, os.cpu_count() or 1}):
        numba.set_num_threads(threads)
        loop = sample(force._loops._sum, repeats)
        figures.update({f"force_{threads}_{which}": value for which, value in loop.items()})


def of_steps(analysis: rbs.Analysis, dt: float, steps: int, runs: int = 9) -> Figures:
    """Best, median and largest seconds of a whole step; a run of so many steps is one measurement."""
    seconds = [
        analysis.run(steps=run * steps, dt=dt, progress=False).seconds / steps for run in range(1, runs + 2)
    ][1:]  # fmt: skip
    return {"step_best": min(seconds), "step_median": statistics.median(seconds), "step_largest": max(seconds)}


# -- rows ----------------------------------------------------------------------------------------------------------


def limits(threads: str) -> Figures:
    """What the machine can do."""
    from machine import limits

    return limits(int(threads))


def scene(what: str, size: str, storage: str, precision: str = "double") -> Figures:
    """Force loop, whole step, search, compilation and memory of a bar, square or cube with breaking bonds."""
    from rbs_plugins import VelocityVerlet
    from rbs_plugins.fields import displacement, velocity

    dimension, n = DIMENSION[what], int(size)
    part, first, again = body((n,) * dimension, storage, precision)
    force = brittle(part)
    figures: Figures = {"nodes": len(part), "bonds": len(part.bonds), "search": again}
    work = len(part.bonds)
    with rbs.Analysis(VelocityVerlet(part).step([force])) as analysis:
        begin = time.perf_counter()
        dt = 0.5 * analysis.stable_dt()
        figures["compile"] = time.perf_counter() - begin + first - again
        shake(part)
        force.begin(analysis.clock)  # a lattice looks at its bonds then
        of_force(force, int(np.clip(2e8 / work, 5, 40)), figures)
        part[displacement] = 0.0
        part[velocity] = 1e-3 * np.random.default_rng(1).standard_normal(part.positions.shape)
        figures.update(of_steps(analysis, dt, int(np.clip(1.5e8 / work, 3, 100))))
    figures["bytes_per_bond"] = part.bonds.nbytes / work
    figures["peak_GiB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return figures


def law(size: str) -> Figures:
    """The force loop of the built-in material, and of a user's law with a branch, in turn; seconds."""
    import numba
    from machine import sample

    from rbs_plugins import CriticalStretch, PairwiseForce

    def bilinear(stretch, c, s_yield):
        if stretch < s_yield:
            return c * stretch
        return c * s_yield

    part, *_ = body((int(size),) * 2, "lattice")
    shake(part)
    built_in = brittle(part)
    own = PairwiseForce(part, bilinear, CriticalStretch(0.04472), c=built_in.c, s_yield=0.02, active=False)
    loops: dict[str, list[Callable[[], object]]] = {"built_in": [], "users": []}
    for name, force in (("built_in", built_in), ("users", own)):
        with rbs.Analysis([force]) as analysis:
            analysis.prepare()
            force.begin(analysis.clock)
            loops[name] = force._loops._sum
    numba.set_num_threads(1)
    seconds: dict[str, list[float]] = {name: [] for name in loops}
    for _ in range(5):
        for name, loop in loops.items():
            seconds[name].append(sample(loop, 7)["best"])
    figures = {f"{name}_best": min(values) for name, values in seconds.items()}
    return {**figures, "ratio": figures["users_best"] / figures["built_in_best"]}


def parts(model: str, count: str, columns: str = "25", rows: str = "20") -> Figures:
    """A step of many small parts, and of one with as many nodes; seconds."""
    from rbs_plugins import VelocityVerlet
    from rbs_plugins.fields import velocity

    def step(number: int, shape: tuple[int, int]) -> Figures:
        relations: list[rbs.Relation] = []
        begin = time.perf_counter()
        for k in range(number):
            part, *_ = body(shape, name=f"part {k}")
            part[velocity] = 1e-3 * np.random.default_rng(k).standard_normal(part.positions.shape)
            relations += VelocityVerlet(part).step([brittle(part, model)])
        analysis = rbs.Analysis(relations)
        dt = 0.5 * analysis.stable_dt()
        made = time.perf_counter() - begin
        return {**of_steps(analysis, dt, 5, runs=7), "made": made}

    small, n = (int(columns), int(rows)), int(count)
    step(2, small)  # compiles
    many, one = step(n, small), step(1, (1000, small[0] * small[1] * n // 1000))
    figures = {**{f"many_{k}": v for k, v in many.items()}, **{f"one_{k}": v for k, v in one.items()}}
    return {**figures, "ratio": many["step_best"] / one["step_best"]}


def frame(size: str) -> Figures:
    """Seconds and megabytes of a frame with four vector fields, written as VTKHDF, and of a plain write of as much."""
    from machine import spread

    from rbs_plugins import VTKHDFExporter

    part, *_ = body((int(size),) * 2)
    fields = [rbs.Field(f"v{k}", "node", "vector", "m", "v", "Made up for the benchmark.") for k in range(4)]
    for k, field in enumerate(fields):
        part[field] = np.random.default_rng(k).standard_normal(part.positions.shape)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "frames.vtkhdf"
        analysis = rbs.Analysis([VTKHDFExporter(part, fields, path)])
        seconds = []
        for k in range(1, 26):
            report = analysis.run(steps=k, dt=1.0, force_dt=True, progress=False)
            seconds.append(report.rows[0].seconds)
        megabytes, plain = path.stat().st_size / 25 / 1e6, []
        numbers = np.random.default_rng(9).standard_normal(int(megabytes * 1e6 / 8))
        path.unlink()  # the plain writes find the memory in use that the frames have had to ask for
        with (Path(folder) / "plain").open("wb", buffering=0) as file:
            for _ in range(25):
                begin = time.perf_counter()
                file.write(numbers.data)
                plain.append(time.perf_counter() - begin)
        (Path(folder) / "plain").unlink()
        analysis = rbs.Analysis([VTKHDFExporter(part, fields, path)])
        runs = [analysis.run(steps=k, dt=1.0, force_dt=True, progress=False) for k in range(1, 26)]
        again = [run.rows[0].seconds for run in runs]
    figures = {"first_frame": seconds, "plain_write": plain, "frame": again}
    found = {f"{name}_{k}": v for name, values in figures.items() for k, v in spread(values[1:]).items()}
    return {**found, "MB_per_frame": megabytes}


def exporters(kind: str, size: str) -> Figures:
    """Seconds and megabytes of a frame of every exporter, with four vector fields; pictures draw one."""
    from machine import spread

    import rbs_plugins as rp
    from rbs_core.part import Connection
    from rbs_plugins.fields import displacement, volume

    dimension = DIMENSION[kind]
    part, *_ = body((int(size),) * dimension)
    side = int(size) * SPACING
    center = [side, *(0.0,) * (dimension - 1)]
    other = rbs.Part("other", rbs.Box(size=[side] * dimension, center=center)).discretize(SPACING)
    shake(part)
    own = [rbs.Field(f"v{k}", "node", "vector", "m", "v", "Made up for the benchmark.") for k in range(3)]
    for k, field in enumerate(own):
        part[field] = np.random.default_rng(k).standard_normal(part.positions.shape)
    fields = [displacement, *own]
    reductions = [each(field) for field in fields for each in (rp.total, rp.smallest, rp.largest)]
    means = [rp.mean(field, weights=volume) for field in fields]
    figures: Figures = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for what, exporter in {
            "VTK": rp.VTKExporter(part, fields, folder / "a"),
            "VTK_radius": rp.VTKExporter(part, fields, folder / "b", radius=True),
            "VTKHDF": rp.VTKHDFExporter(part, fields, folder / "c"),
            "VTKHDF_gzip": rp.VTKHDFExporter(part, fields, folder / "d", compression="gzip"),
            "HDF5": rp.HDF5Exporter(part, fields, folder / "e"),
            "HDF5_single": rp.HDF5Exporter(part, fields, folder / "f", precision="single"),
            "HDF5_lzf": rp.HDF5Exporter(part, fields, folder / "g", compression="lzf"),
            "HDF5_plain": rp.HDF5Exporter(part, fields, folder / "h", compression=None),
            "CSV": rp.CSVExporter(part, [*reductions, *means], folder / "i.csv"),
            "Text": rp.TextExporter(part, fields, folder / "j"),
            "Picture": rp.PictureExporter(part, displacement, folder / "k"),
            "Animation": rp.AnimationExporter(part, displacement, folder / "l.gif"),
            "Neighborhood": rp.NeighborhoodExporter(part, folder / "m", when=rbs.always),
            "Connection": rp.ConnectionExporter(
                Connection(part, other, RATIO * SPACING), folder / "n", when=rbs.always
            ),
        }.items():
            report = rbs.Analysis([exporter]).run(steps=1, dt=1.0, force_dt=True, progress=False)
            figures[f"{what}_first"] = report.rows[0].seconds
            analysis = rbs.Analysis([exporter])
            runs = [analysis.run(steps=k, dt=1.0, force_dt=True, progress=False) for k in range(1, 8)]
            figures[f"{what}_median"] = spread([run.rows[0].seconds for run in runs])["median"]
            files = [path for path in folder.rglob("*") if path.is_file()]
            figures[f"{what}_MB"] = sum(path.stat().st_size for path in files) / 7e6
            for path in files:
                path.unlink()
    return figures


def case(size: str) -> Figures:
    """The plate with a pre-existing crack, 1250 steps with 50 frames: seconds of the command and of its parts."""
    import subprocess

    simulation = Path(__file__).parents[2] / "simulations" / "plate_with_crack.py"
    with tempfile.TemporaryDirectory() as folder:
        command = ["rbs", "run", str(simulation), "--set", f"n={size}", "--out", folder, "--quiet"]
        begin = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        whole = time.perf_counter() - begin
        report = json.loads((Path(folder) / "result.json").read_text(encoding="utf-8"))["run"]
    rows = {row["name"].split()[0]: row["seconds"] for row in report["relations"]}
    named = {"bonds": "BondBased", "frames": "VTKHDFExporter", "picture": "PictureExporter"}
    figures = {name: rows[relation] for name, relation in named.items()}
    return {"command": whole, "to_last_frame": whole - figures["picture"], "steps": report["seconds"], **figures}


def main() -> None:
    row, *arguments = sys.argv[1:]
    from equilibria import equilibrium
    from solids import solid

    rows = [limits, law, solid, parts, frame, exporters, case, scene, equilibrium]
    print(json.dumps({each.__name__: each for each in rows}[row](*arguments)))


if __name__ == "__main__":
    main()
