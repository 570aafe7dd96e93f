"""The command line: `rbs run FILE.py`, `rbs show DIR`, `rbs list`, `rbs describe NAME`; also `python -m rbs_core`."""

from __future__ import annotations

import logging
import os
import sys
import traceback
from collections.abc import Sequence

from rbs_core.command.parser import make_parser
from rbs_core.errors import DishonestRelation, NotFinite, RBSError
from rbs_core.report import configure_logging, log
from rbs_core.report.levels import FILE_ONLY, logging_of_a_command

SUCCESS, FAILED, USAGE, INTERRUPTED = 0, 1, 2, 130
DURING_A_RUN = (NotFinite, DishonestRelation)  # other errors are found in what was given

_parser = make_parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command.

    Args:
        arguments: words behind `rbs`; those of the process if not given.

    Returns:
        0 after success, 1 after a failure during a run, 2 if something given cannot be used, 130 after Ctrl-C.

    Raises:
        SystemExit: on words that are no command (2), and after a help (0).
    """
    parser = make_parser()
    options = parser.parse_args(arguments)
    if options.command is None:
        parser.print_help()
        return USAGE
    with logging_of_a_command():
        configure_logging(getattr(options, "level", "process"))
        try:
            return int(options.command(options))
        except RBSError as error:
            log.error("%s: %s", type(error).__name__, error)
            return FAILED if isinstance(error, DURING_A_RUN) else USAGE
        except MemoryError as error:
            log.error("MemoryError: %s: take fewer nodes, a smaller horizon, or precision='single'", error)
            return FAILED
        except KeyboardInterrupt:
            log.error("interrupted")
            return INTERRUPTED
        except BrokenPipeError:  # whoever read the output has seen enough, as in `rbs list | head`
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return SUCCESS
        except Exception:
            if log.isEnabledFor(logging.ERROR):
                log.error("%s", traceback.format_exc().rstrip(), extra=FILE_ONLY)
            raise  # a mistake in code: Python tells where
