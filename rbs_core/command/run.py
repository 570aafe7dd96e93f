"""`rbs run FILE.py`: the scene of a file, its measure, and the folder of the results."""

from __future__ import annotations

import argparse
import ast
import importlib.util
import inspect
import json
import os
import platform
import shlex
import shutil
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from rbs_core.analysis import Analysis
from rbs_core.checkpoint import Checkpoint
from rbs_core.command.describe import similar
from rbs_core.errors import BadInput
from rbs_core.files import writable_folder, written_whole
from rbs_core.report import Report, log
from rbs_core.report.levels import FILE_ONLY, PROCESS, TIMING, add_file, shown

INTERRUPTED = 130


def run(options: argparse.Namespace) -> int:
    """Runs the scene of a file, and its measure.

    Raises:
        BadInput: if the file, its scene or an argument cannot be used; and what the run raises.
    """
    file = Path(options.file)
    module = _load(file)
    given = dict(_assignment(text) for text in options.set)
    out = writable_folder(Path(options.out) if options.out else Path("out") / file.stem)
    begin = time.perf_counter()
    analysis = _scene(module, file, given, out)
    resume = _checkpoint(analysis) if options.resume else None
    add_file(out / "run.log", options.log_level)  # now: a misspelt word must not touch the results of before
    log.info("rbs run %s", _command(options), extra=FILE_ONLY)
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
        _say(f"nothing to do: the run is at step {report.step} already, the last one asked for; {out} is left as it is")
        return 0
    if shown(TIMING):
        print(report)
        print(report.memory_table())
    finished = report.stopped == "finished" and options.steps is None
    try:
        if finished and hasattr(module, "measure"):
            measured = module.measure(analysis)
            for line in measured_lines(measured):
                print(line)
                log.info(line, extra=FILE_ONLY)
    finally:
        seconds = time.perf_counter() - begin
        _write_result(out / "result.json", file, given, measured, report, seconds)
    if report.stopped == "interrupted" and any(isinstance(r, Checkpoint) for r in analysis.relations):
        _say(f"saved in {_checkpoint(analysis)}: go on with --resume")
    _say(f"results in {out}{os.sep}  ({seconds:.1f} s): rbs show {shlex.quote(str(out))}")
    return INTERRUPTED if report.stopped == "interrupted" else 0


def _say(text: str) -> None:
    """Tells what happened, on standard output like the numbers, and in the log."""
    if shown(PROCESS):
        print(text)
    log.info(text, extra=FILE_ONLY)


def _command(options: argparse.Namespace) -> str:
    """The words of the command that matter for the results."""
    words = [options.file, *(word for text in options.set for word in ("--set", text))]
    words += ["--steps", str(options.steps)] if options.steps is not None else []
    return shlex.join([*words, *(["--resume"] if options.resume else [])])


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
            asked = similar(name, list(parameters))
            raise BadInput(f"--set {name}: scene of {file} takes {', '.join(parameters)}{asked}")
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


def measured_lines(measured: Mapping[str, Any]) -> list[str]:
    """What was measured, as lines of name and number; arrays and lists are left out."""
    plain = {name: value for name, value in measured.items() if not isinstance(value, list | dict | np.ndarray)}
    width = max((len(name) for name in measured), default=0)
    return [
        f"  {name:<{width}}  {value:.6g}" if isinstance(value, float) else f"  {name:<{width}}  {value}"
        for name, value in plain.items()
    ]


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
