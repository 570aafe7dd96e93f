"""Speed and memory of RBS on this machine: `python tests/benchmarks/bench.py [--quick] [--json FILE]`.

Every figure stands beside limits of the machine measured in the same run. Nothing is asserted: a noisy machine is not a
failure. A row is measured in a process of its own, so that compile times and peak memory belong to it alone.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
KINDS = (("lattice", "double"), ("lattice", "single"), ("list", "double"))
TARGETS = {  # of the reference machine (2 cores of an AMD Zen 5 at 4.4 GHz): ms, seconds, GiB
    "plate lattice double": {"step_ms": 1.8, "search_s": 0.1, "compile_cold_s": 3.0, "compile_cached_s": 0.5},
    "plate lattice single": {"step_ms": 1.1, "search_s": 0.1},
    "plate list double": {"force_ms": 10.0, "step_over_force": 1.25, "search_s": 0.15},
    "cube lattice double": {"step_ms": 45.0, "peak_GiB": 0.47},
    "cube list double": {"force_ms": 60.0, "step_over_force": 1.25, "search_s": 2.5, "peak_GiB": 3.5},
}  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="small sizes, to see that it works")
    parser.add_argument("--json", type=Path, help="also write the figures to a file")
    options = parser.parse_args()
    sizes = {"plate": 50 if options.quick else 503, "cube": 20 if options.quick else 100}
    figures: dict[str, object] = {"limits": {n: _row("limits", n) for n in sorted({1, os.cpu_count() or 1})}}
    with tempfile.TemporaryDirectory() as folder:
        Path(folder).chmod(0o700)
        cache = {"RBS_CACHE": folder, "NUMBA_CACHE_DIR": folder}
        for scene in ("plate", "cube"):
            for kind in KINDS:
                rows = {"cold": _row(scene, sizes[scene], *kind, **cache)} if scene == "plate" else {}
                rows["warm"] = _row(scene, sizes[scene], *kind, **cache)
                figures[" ".join((scene, *kind))] = rows
    _print(figures)
    if options.json:
        options.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")


def _row(what: str, size: int, *kind: str, **environment: str) -> dict[str, float]:
    command = [sys.executable, str(HERE / "rows.py"), what, str(size), *kind]
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(done.stderr)
    return json.loads(done.stdout.splitlines()[-1])


def _print(figures: dict) -> None:
    for threads, limit in figures["limits"].items():
        print(f"machine, {threads} threads: " + ", ".join(f"{name} {value:.3g}" for name, value in limit.items()))
    cores = max(figures["limits"])
    limit = figures["limits"][cores]
    for scene, rows in figures.items():
        if scene == "limits":
            continue
        root = (
            "single_sqrt_and_division_ns" if scene.endswith("single") and "lattice" in scene else "sqrt_and_division_ns"
        )
        warm = rows["warm"]
        print(
            f"\n{scene}: {warm['nodes']:.0f} nodes, {warm['bonds']:.0f} directed bonds, "
            f"{warm['bytes_per_bond']:.1f} bytes per bond"
        )
        for n in sorted({1, cores}):
            best, median, largest = (warm[f"force_{n}_{which}"] for which in ("best", "median", "largest"))
            rate = warm["bonds"] / best / n / 1e6
            roof = figures["limits"][n][root] * 1e-9 * warm["bonds"] / best
            print(
                f"  force, {n} threads: {best * 1e3:.2f} ms (median {median * 1e3:.2f}, largest {largest * 1e3:.2f}), "
                f"{rate:.0f} Mbond/s per core, {roof:.0%} of the sqrt + division limit"
            )
        if cores > 1:
            print(f"  scaling 1 -> {cores} threads: {warm['force_1_best'] / warm[f'force_{cores}_best']:.2f}")
        moved = warm["bytes_per_bond"] * warm["bonds"] / warm[f"force_{cores}_best"] / 1e9
        print(f"  bytes moved: {moved:.1f} GB/s, {moved / limit['triad_memory_GB_per_s']:.0%} of the triad from memory")
        reached = {
            "force_ms": warm[f"force_{cores}_best"] * 1e3,
            "step_ms": warm["step_median"] * 1e3,
            "step_over_force": warm["step_over_force"],
            "search_s": warm["search"],
            "peak_GiB": warm["peak_GiB"],
            "compile_cold_s": rows["cold"]["compile"] if "cold" in rows else None,
            "compile_cached_s": warm["compile"] if "cold" in rows else None,
        }
        for name, value in reached.items():
            if value is not None:
                target = TARGETS.get(scene, {}).get(name)
                print(f"  {name:<18} {value:8.3f}" + ("" if target is None else f"   target {target:g}"))


if __name__ == "__main__":
    main()
