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

__all__ = [
    "REPORT_SUFFIXES",
    "Chart",
    "Report",
    "ReportColumn",
    "ReportTable",
    "check_report_suffix",
    "drift",
]
