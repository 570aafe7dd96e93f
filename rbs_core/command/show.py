"""`rbs show DIR`: what a run has left in its folder."""

from __future__ import annotations

import argparse
import json
import webbrowser
from pathlib import Path
from typing import Any

from rbs_core.command.describe import similar
from rbs_core.command.frames import KINDS, Series, magnitudes, pictures_of, series_of, table_of
from rbs_core.command.picture import draw
from rbs_core.command.run import measured_lines
from rbs_core.errors import BadInput
from rbs_core.memory import as_text
from rbs_core.plugins import registry
from rbs_core.report import Report

RESULT = "result.json"


def show(options: argparse.Namespace) -> int:
    """Prints the results of a run, the fields of a frame, or draws it.

    Raises:
        BadInput: if the folder holds no results, or not what was asked for.
    """
    folder = Path(options.folder)
    if not folder.is_dir():
        raise BadInput(f"there is no folder {folder}: name the one that `rbs run` has told at its end")
    if options.frame is None and options.field is None and options.picture is None:
        if not options.open:
            _everything(folder)
    else:
        _frame(folder, options)
    if options.open:
        _open(folder, options.picture)
    return 0


# -- the whole folder -------------------------------------------------------------------------------------------------


def _everything(folder: Path) -> None:
    files = [path for path in sorted(folder.iterdir()) if path.is_file() and not path.name.startswith(".")]
    if not files:
        runs = sorted(str(result.parent) for result in folder.glob(f"*/{RESULT}"))
        cure = f"rbs show {' or '.join(runs)}" if runs else f"run something into it, rbs run FILE.py --out {folder}"
        raise BadInput(f"{folder} holds no files: {cure}")
    if (folder / RESULT).is_file():
        _result(folder / RESULT)
    else:
        print(f"no {RESULT}: the run goes on, broke off before its first step, or was none of `rbs run`")
    print("files")
    pictures = pictures_of(folder)
    told = set(pictures)
    frames = {path for path in files if path.suffix in (".vtu", ".vtp", ".vtk")}
    width = max(len(path.name) for path in files)
    for path in files:
        if path not in told and path not in frames:
            print(f"  {path.name:<{width}}  {as_text(path.stat().st_size):>8}  {_content(path)}".rstrip())
    if frames:
        print(f"  {len(frames)} files of single frames")
    if pictures:
        count = f"{len(pictures)} pictures, the last one is " if len(pictures) > 1 else "picture "
        print(f"  {count}{pictures[-1]}")


def _result(path: Path) -> None:
    try:
        result = json.loads(path.read_text(encoding="utf-8"))
        report = Report.from_dict(result["run"])
        arguments = ", ".join(f"{name}={value!r}" for name, value in result["arguments"].items())
        measured = {name: "not finite" if value is None else value for name, value in result["measured"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise BadInput(f"{path} is no result of `rbs run` ({type(error).__name__}: {error}): run again") from None
    print(f"{result.get('case', path.parent.name)}({arguments})")
    print(report)
    if report.memory:
        print(report.memory_table())
    if measured:
        print("measured")
        for line in measured_lines(measured):
            print(line)


def _content(path: Path) -> str:
    """What is in a file, in words."""
    try:
        if path.suffix in KINDS:
            series = KINDS[path.suffix](path)
            if not series.times:
                return "no frames yet"
            _, fields = series.read(len(series.times) - 1)
            times = f"{series.times[0]:.4g} to {series.times[-1]:.4g} s"
            return f"{len(series.times)} frames, {times}: {', '.join(fields) or 'positions only'}"
        if path.suffix == ".csv":
            columns, rows = table_of(path)
            return f"{rows} rows: {', '.join(columns)}"
    except (BadInput, OSError, ValueError) as error:
        return f"cannot be read: {error}"
    kinds = {RESULT: "arguments, numbers, times, machine", "run.log": "messages"}
    by_end = {".npz": "checkpoint: go on with --resume", ".py": "the file that was run"}
    return kinds.get(path.name, by_end.get(path.suffix, ""))


# -- one frame --------------------------------------------------------------------------------------------------------


def _frame(folder: Path, options: argparse.Namespace) -> None:
    series = _series(folder, options.series)
    number = series.number(-1 if options.frame is None else options.frame)
    points, fields = series.read(number)
    if options.field is not None and options.field not in fields:
        asked = similar(options.field, list(fields))
        raise BadInput(f"{series.path} has no field '{options.field}'{asked}; it has {', '.join(fields) or 'none'}")
    picture = None if options.picture is None else _png(options.picture)
    if picture is not None and not fields:
        raise BadInput(f"{series.path} holds positions only: there is nothing to colour a picture by")
    chosen = {options.field: fields[options.field]} if options.field else fields
    print(f"{series.path}, frame {number} of {len(series.times)}, time {series.times[number]:.6g} s")
    print(f"  {len(points)} nodes in {_box(points)}")
    width = max([5, *(len(name) for name in chosen)])
    if chosen:
        print(f"  {'field':<{width}}  {'unit':<7} {'least':>12} {'mean':>12} {'most':>12}")
    for name, values in chosen.items():
        sizes = magnitudes(values)
        numbers = " ".join(f"{number:>12.5g}" for number in (sizes.min(), sizes.mean(), sizes.max()))
        of = "" if values.ndim == 1 else "  (magnitude)"
        print(f"  {name:<{width}}  {_unit(name):<7} {numbers}{of}")
    if picture is not None:
        name = options.field or next(iter(fields))
        label = f"{name} [{_unit(name)}]" if _unit(name) else name
        title = f"{series.path.stem}, t = {series.times[number]:.4g} s"
        draw(points, magnitudes(fields[name]), label, title, picture)
        print(f"  picture {picture}, by {name}")


def _series(folder: Path, name: str | None) -> Series:
    found = series_of(folder)
    names = [series.path.name for series in found]
    if not found:
        raise BadInput(f"{folder} has no frames ({', '.join(KINDS)}): add an exporter of frames to the scene")
    if name is None and len(found) > 1:
        raise BadInput(f"{folder} has several series of frames: say which, --series {' or '.join(names)}")
    if name is not None and Path(name).name not in names:
        raise BadInput(f"{folder} has no series {name}{similar(name, names)}; it has {', '.join(names)}")
    return found[0] if name is None else found[names.index(Path(name).name)]


def _png(name: str) -> Path:
    path = Path(name)
    if path.suffix != ".png":
        raise BadInput(f"--picture {path}: the name must end with .png")
    if not path.parent.is_dir():
        raise BadInput(f"--picture {path}: there is no folder {path.parent}: make it first")
    return path


def _open(folder: Path, picture: str | None) -> None:
    pictures = [Path(picture)] if picture else pictures_of(folder)
    if not pictures:
        raise BadInput(f"{folder} has no picture: draw one, rbs show {folder} --picture last.png --open")
    if not webbrowser.open(pictures[-1].resolve().as_uri()):
        raise BadInput(f"nothing here can show pictures: look at {pictures[-1]} elsewhere")


def _unit(name: str) -> str:
    """Unit of a field of the vocabulary, or nothing."""
    known = registry().fields()
    return known[name].unit if name in known else ""


def _box(points: Any) -> str:
    low, high = points.min(axis=0), points.max(axis=0)
    return " x ".join(f"[{a:.4g}, {b:.4g}]" for a, b in zip(low, high, strict=True) if (a, b) != (0.0, 0.0)) + " m"
