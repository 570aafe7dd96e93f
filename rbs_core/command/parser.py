"""What may be typed behind `rbs`, and the help that teaches it."""

from __future__ import annotations

import argparse

from rbs_core.command.describe import describe, list_all
from rbs_core.command.run import run
from rbs_core.command.show import show
from rbs_core.report import LEVELS

WHOLE = """\
RBS simulates solids that crack: peridynamics, where a simulation is a list of relations.

A simulation is a Python file with a function scene(...) that returns an Analysis. Run it, look at what it left
behind, and find out what else there is to build a scene from:

  rbs run simulations/plate_with_crack.py --set n=100     a quick look: every argument of scene(...) can be set
  rbs show out/plate_with_crack                           what was measured, where the time went, frames, pictures
  rbs list                                                relations, fields, geometries, plugins
  rbs describe BondBased                                  what one of them does, reads, writes and takes
"""
AFTER = """\
`rbs COMMAND --help` explains a command, with examples.

exit codes
  0    success
  1    the run failed: numbers became infinite, a relation broke its contract, the disk is full, or Python raised
  2    something given cannot be used: a word of the command, the file, an argument, the scene, a checkpoint
  130  stopped by Ctrl-C

environment
  NUMBA_NUM_THREADS=2   threads; results do not depend on it, to the bit
  RBS_MEMORY=8GB        refuse scenes that need more; `off` to refuse none; what is free, if not given
  RBS_PLUGINS=-granite  load all plugins but this one
"""
RUN = """\
Runs scene(...) of a Python file, then its measure(analysis) if it has one.

A bar shows how far the run is; one of more than a minute says first what it needs. Ctrl-C once ends it after the step
and saves the checkpoint of the scene, Ctrl-C twice breaks it off.
"""
RUN_AFTER = """\
examples
  rbs run simulations/plate_with_crack.py
  rbs run simulations/plate_with_crack.py --set n=100 --set speed=50 --out out/quick
  rbs run simulations/plate_with_crack.py --set release="at once"     text with blanks in quotes
  rbs run simulations/plate_with_crack.py --steps 10                  does it work at all?
  rbs run simulations/plate_with_crack.py --resume                    go on after Ctrl-C, or a crash
  rbs run simulations/plate_with_crack.py --level error > numbers     for scripts: measured numbers, errors

levels, each with all that stands above it
  off      nothing but the measured numbers
  error    what ended a run, or kept it from beginning
  warning  what may be wrong: nodes without bonds, cuts that broke nothing
  process  what a run needs if it takes more than a minute, progress, where the results are
  timing   where time and memory went: relation by relation, field by field
  debug    what is allocated, and every step with the time of every relation

the folder of the results
  result.json   arguments, measured numbers, times, memory, the machine
  run.log       the messages, with dates; a later run adds its own
  a copy of the file, and whatever the exporters of the scene write
"""
SHOW = """\
Shows what a run has left in its folder: measured numbers, where time and memory went, frames, tables, pictures.
"""
SHOW_AFTER = """\
examples
  rbs show out/plate_with_crack
  rbs show out/plate_with_crack --frame -1                           ranges of all fields in the last frame
  rbs show out/plate_with_crack --frame 7 --field damage             of one field, in frame 7 (the first one is 0)
  rbs show out/plate_with_crack --picture last.png --field damage    draws the last frame, without a screen
  rbs show out/plate_with_crack --open                               opens the last picture that the run has drawn
"""
LIST_AFTER = """\
examples
  rbs list
  rbs list | grep -i energy
"""
DESCRIBE = """\
Explains a relation (signature, contract, source), a field (meaning, unit, who reads and writes it) or a geometry.
"""
DESCRIBE_AFTER = """\
examples
  rbs describe BondBased
  rbs describe damage
  rbs describe Ball
"""


def make_parser() -> argparse.ArgumentParser:
    """The parser of `rbs` with all its commands."""
    parser = _parser("rbs", WHOLE, AFTER)
    parser.set_defaults(command=None)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", parser_class=argparse.ArgumentParser)

    def command(name: str, summary: str, text: str, after: str) -> argparse.ArgumentParser:
        raw = argparse.RawDescriptionHelpFormatter
        return commands.add_parser(name, help=summary, description=text, epilog=after, formatter_class=raw)

    _run(command("run", "run the scene of a Python file", RUN, RUN_AFTER))
    _show(command("show", "show the results of a run", SHOW, SHOW_AFTER))
    everything = "list relations, fields, geometries and plugins"
    command("list", everything, f"{everything.capitalize()}.\n", LIST_AFTER).set_defaults(command=list_all)
    about = command("describe", "explain a relation, field or geometry", DESCRIBE, DESCRIBE_AFTER)
    about.add_argument("name", help="as `rbs list` shows it")
    about.set_defaults(command=describe)
    return parser


def _parser(name: str, text: str, after: str) -> argparse.ArgumentParser:
    raw = argparse.RawDescriptionHelpFormatter
    return argparse.ArgumentParser(prog=name, description=text, epilog=after, formatter_class=raw)


def _run(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("file", help="Python file with a function scene(...) that returns an Analysis")
    add(
        "--set", action="append", default=[], metavar="NAME=VALUE",
        help="argument of scene(...), a Python literal or text; may be repeated",
    )  # fmt: skip
    add("--out", metavar="DIR", help="folder of the results (default: out/<name of the file>)")
    add("--steps", type=int, help="total number of steps, instead of what the scene says; leaves out measure(...)")
    add("--resume", action="store_true", help="go on from the checkpoint of the scene, if there is one")
    add("--quiet", action="store_true", help="no progress")
    add(
        "--level", choices=LEVELS, default="timing", metavar="LEVEL",
        help=f"how much to tell on the terminal: {', '.join(LEVELS)} (default: timing)",
    )  # fmt: skip
    add(
        "--log-level", choices=LEVELS, default="timing", metavar="LEVEL",
        help="how much to write into run.log (default: timing); off for no such file",
    )  # fmt: skip
    parser.set_defaults(command=run)


def _show(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("folder", metavar="DIR", help="folder of the results, as given to `rbs run --out`")
    add("--frame", type=int, metavar="N", help="show the fields of a frame: 0 is the first, -1 the last")
    add("--field", metavar="NAME", help="this field only; what --picture is coloured by")
    add("--series", metavar="FILE", help="which series of frames, if the folder has several")
    add("--picture", metavar="FILE.png", help="draw a frame, the last one if --frame says no other")
    add("--open", action="store_true", help="open the picture (the last one of the run, or that of --picture)")
    parser.set_defaults(command=show)
