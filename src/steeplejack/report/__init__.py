"""The mission report: figures of merit, drawings and one HTML page, from the log alone."""

from steeplejack.report.analysis import Analysis, Summary, analyse
from steeplejack.report.log import Log, read_log
from steeplejack.report.page import write_report

__all__ = ["Analysis", "Log", "Summary", "analyse", "read_log", "write_report"]
