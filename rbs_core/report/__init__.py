"""What a run tells its user: messages of six levels, progress, and where time and memory went."""

from __future__ import annotations

from rbs_core.report.levels import LEVELS, configure_logging, log
from rbs_core.report.progress import Progress
from rbs_core.report.table import Held, Report, Row

__all__ = ["LEVELS", "Held", "Progress", "Report", "Row", "configure_logging", "log"]
