"""Reports: what is asked of several gamuts, readings or standards, and the files of the answers.

A report arranges answers of `gamutcore.questions`. `Report` holds sentences, conditions, tables and
charts, and writes them as text, CSV, JSON, a workbook, a page or PDF.
"""

from gamutcore.reports.document import (
    REPORT_SUFFIXES,
    Chart,
    Report,
    ReportColumn,
    ReportTable,
    check_report_suffix,
)
from gamutcore.reports.drift import drift
from gamutcore.reports.gamuts import distinct_name
from gamutcore.reports.match import (
    GamutMatch,
    MatchTerms,
    gathered_match,
    match_gamut,
    match_report,
)
from gamutcore.reports.matrix import compare_all, matrix_report
from gamutcore.reports.signals import SIGNAL_COUNTS, signal_codes, write_signals
from gamutcore.reports.standards import (
    STANDARDS,
    Standard,
    find_standard,
    report,
    standard_intent,
)

__all__ = [
    "REPORT_SUFFIXES",
    "SIGNAL_COUNTS",
    "STANDARDS",
    "Chart",
    "GamutMatch",
    "MatchTerms",
    "Report",
    "ReportColumn",
    "ReportTable",
    "Standard",
    "check_report_suffix",
    "compare_all",
    "distinct_name",
    "drift",
    "find_standard",
    "gathered_match",
    "match_gamut",
    "match_report",
    "matrix_report",
    "report",
    "signal_codes",
    "standard_intent",
    "write_signals",
]
