"""The report of a climb: figures of merit, drawings and one HTML page, from the log alone."""

from steeplejack.report.climb.analysis import ClimbSummary, summarise
from steeplejack.report.climb.log import ClimbLog, film_of, is_climb, read_climb
from steeplejack.report.climb.page import write_climb_report

__all__ = ["ClimbLog", "ClimbSummary", "film_of", "is_climb", "read_climb", "summarise", "write_climb_report"]
