"""The command line: `rbs run FILE.py`, `rbs list`, `rbs describe NAME`; also `python -m rbs_core`."""

from __future__ import annotations

import argparse
import ast
import importlib.util
import inspect
import json
import logging
import os
import platform
import shutil
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from rbs_core.analysis import Analysis
from rbs_core.checkpoint import Checkpoint
from rbs_core.errors import BadInput, RBSError
from rbs_core.files import writable_folder, written_whole
from rbs_core.plugins import registry
from rbs_core.relation import WORDS, Relation
from rbs_core.report import Report

INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command; returns 0, 1 after an error with a message, 2 on wrong usage, 130 after Ctrl-C."""
    parser = _parser()
    options = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    if options.command is None:
        parser.print_help()
        return 2
    try:
        return int(options.command(options))
    except RBSError as error:
        print(f"rbs: {type(error).__name__}: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("rbs: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # whoever read the output has seen enough, as in `rbs list | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="rbs", description="Relation-Based Simulator for peridynamics.")
    parser.set_defaults(command=None)
    commands = parser.add_subparsers(title="commands", metavar="")
    run = commands.add_parser(
        "run",
        help="run the scene of a Python file",
        description="Runs scene(...) of a file, then its measure(analysis); leaves pictures, tables and result.json.",
        epilog="example: rbs run simulations/plate_with_crack.py --set n=100 --set speed=50",
    )
    run.add_argument("file", help="Python file with a function scene(...) that returns an Analysis")
    run.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="argument of scene(...)")
    run.add_argument("--out", metavar="DIR", help="folder of the results (default: out/<name of the file>)")
    run.add_argument(
        "--steps", type=int, help="total number of steps, instead of what the scene says; measure(...) is left out then"
    )
    run.add_argument("--resume", action="store_true", help="go on from the checkpoint of the scene, if there is one")
    run.add_argument("--quiet", action="store_true", help="no progress")
    run.set_defaults(command=_run)
    show = commands.add_parser("list", help="list relations, fields, geometries and plugins")
    show.set_defaults(command=_list)
    describe = commands.add_parser("describe", help="contract, parameters and source of a relation, field or geometry")
    describe.add_argument("name")
    describe.set_defaults(command=_describe)
    return parser


# -- run --------------------------------------------------------------------------------------------------------------


def _run(options: argparse.Namespace) -> int:
    file = Path(options.file)
    module = _load(file)
    given = dict(_assignment(text) for text in options.set)
    out = writable_folder(Path(options.out) if options.out else Path("out") / file.stem)
    begin = time.perf_counter()
    analysis = _scene(module, file, given, out)
    resume = _checkpoint(analysis) if options.resume else None
    if (out / file.name).resolve() != file.resolve():
        shutil.copyfile(file, out / file.name)
    measured: dict[str, Any] = {}
    try:
        report = analysis.run(steps=options.steps, resume=resume, progress=False if options.quiet else None)
    except BaseException:
        if analysis.report is not None and analysis.report.steps:  # what is in the folder is of this run
            _write_result(out / "result.json", file, given, measured, analysis.report, time.perf_counter() - begin)
        raise
    if report.steps == 0:
        print(
            f"nothing to do: the run is at step {report.step} already, the last one asked for; {out} is left as it is"
        )
        return 0
    print(report)
    finished = report.stopped == "finished" and options.steps is None
    try:
        if finished and hasattr(module, "measure"):
            measured = module.measure(analysis)
            _print_measured(measured)
    finally:
        seconds = time.perf_counter() - begin
        _write_result(out / "result.json", file, given, measured, report, seconds)
    if report.stopped == "interrupted" and any(isinstance(r, Checkpoint) for r in analysis.relations):
        print(f"saved in {_checkpoint(analysis)}: go on with --resume")
    print(f"results in {out}{os.sep}  ({seconds:.1f} s)")
    return INTERRUPTED if report.stopped == "interrupted" else 0


def _load(file: Path) -> ModuleType:
    if not file.is_file():
        raise BadInput(f"there is no file {file}")
    sys.path.insert(0, str(file.parent.resolve()))
    spec = importlib.util.spec_from_file_location(file.stem, file)
    if spec is None or spec.loader is None:
        raise BadInput(f"{file} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[file.stem] = module
    spec.loader.exec_module(module)
    if not callable(getattr(module, "scene", None)):
        raise BadInput(f"{file} has no function scene(...) that returns an Analysis")
    return module


def _assignment(text: str) -> tuple[str, Any]:
    name, equal, value = text.partition("=")
    if not equal or not name.isidentifier():
        raise BadInput(f"--set {text}: write NAME=VALUE, e.g. --set n=100")
    try:
        return name, ast.literal_eval(value)
    except (ValueError, SyntaxError):
        return name, value


def _scene(module: ModuleType, file: Path, given: dict[str, Any], out: Path) -> Analysis:
    parameters = inspect.signature(module.scene).parameters
    for name in given:
        if name not in parameters:
            raise BadInput(f"--set {name}: scene of {file} takes {', '.join(parameters)}")
    if "out" in parameters:
        given = {"out": out, **given}
    analysis = module.scene(**given)
    if not isinstance(analysis, Analysis):
        raise BadInput(f"scene of {file} must return an Analysis, got {analysis!r}")
    return analysis


def _checkpoint(analysis: Analysis) -> Path:
    paths = [relation.path for relation in analysis.relations if isinstance(relation, Checkpoint)]
    if not paths:
        raise BadInput("--resume: the scene has no Checkpoint relation, so nothing was saved")
    return paths[0]


def _print_measured(measured: dict[str, Any]) -> None:
    width = max((len(name) for name in measured), default=0)
    for name, value in measured.items():
        if not isinstance(value, list | dict | np.ndarray):
            print(f"  {name:<{width}}  {value:.6g}" if isinstance(value, float) else f"  {name:<{width}}  {value}")


def _write_result(
    path: Path, file: Path, given: dict[str, Any], measured: dict[str, Any], report: Report, seconds: float
) -> None:
    result = {
        "case": file.stem,
        "arguments": given,
        "measured": measured,
        "seconds": seconds,
        "run": report.as_dict(),
        "machine": {
            "python": platform.python_version(),
            "numpy": np.__version__,
            "platform": platform.platform(),
            "cores": os.cpu_count(),
        },
    }
    with written_whole(path) as partial:
        partial.write_text(json.dumps(_plain(result), indent=2) + "\n", encoding="utf-8")


def _plain(value: Any) -> Any:
    """What JSON can hold: infinity and NaN become null."""
    if isinstance(value, dict):
        return {str(name): _plain(each) for name, each in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value if isinstance(value, str | int | float | None) else str(value)


# -- list and describe ------------------------------------------------------------------------------------------------


def _list(_: argparse.Namespace) -> int:
    known = registry()
    print("relations")
    for name, relation in sorted(known.relations().items()):
        print(f"  {name:<20} {relation.role:<13} {_sentence(relation)}  [{relation.__module__}]")
    print("fields")
    for name, field in sorted(known.fields().items()):
        print(f"  {name:<24} {field.symbol:<6} {field.at} {field.shape}, {field.unit}: {field.doc}")
    print("geometries")
    for name, geometry in sorted(known.geometries().items()):
        print(f"  {name:<20} {_sentence(geometry)}")
    print("plugins")
    for name, source in known.sources.items():
        print(f"  {name:<20} {source}")
    for name, why in known.failed.items():
        print(f"  {name:<20} failed: {why}")
    return 0


def _describe(options: argparse.Namespace) -> int:
    known = registry()
    relation = known.relations().get(options.name)
    field = known.fields().get(options.name)
    if relation is not None:
        print(f"{options.name}{inspect.signature(relation)}\n")
        print(inspect.getdoc(relation) or "")
        print()
        for word in WORDS:
            print(f"  {word:<8} {_fields(relation, word)}")
        print(f"\n{relation.__module__}, {inspect.getsourcefile(relation)}")
        return 0
    if field is not None:
        print(f"{field.name} ({field.symbol}): {field.doc}\n  at {field.at}, {field.shape}, unit {field.unit}")
        for name, each in sorted(known.relations().items()):
            declared = {word: getattr(each, word) for word in WORDS}
            words = [word for word, fields in declared.items() if isinstance(fields, tuple) and field in fields]
            if words:
                print(f"  {name} {', '.join(words)} it")
        open_ended = [name for name, each in known.relations().items() if _depends(each)]
        print(f"  depends on their arguments: {', '.join(sorted(open_ended))} (see rbs describe NAME)")
        return 0
    if options.name in known.geometries():
        geometry = known.geometries()[options.name]
        print(f"{options.name}{inspect.signature(geometry)}\n\n{inspect.getdoc(geometry)}")
        return 0
    names = ", ".join(sorted([*known.relations(), *known.fields(), *known.geometries()]))
    raise BadInput(f"nobody knows '{options.name}'; known are {names}")


def _depends(relation: type[Relation]) -> bool:
    """True if the contract follows from the arguments of an instance."""
    return any(isinstance(getattr(relation, word), property) for word in WORDS)


def _fields(relation: type[Relation], word: str) -> str:
    declared = getattr(relation, word)
    if isinstance(declared, property):
        return f"depends on the arguments: {inspect.getdoc(declared)}"
    return ", ".join(field.name for field in declared) or "nothing"


def _sentence(thing: Any) -> str:
    return (inspect.getdoc(thing) or "").split("\n")[0]
