"""Tables of colours that users give, as files of many kinds or as data frames.

`read_table` reads a file, and states what it understood. The `ColourTable` writes an answer beside
the columns of the file, in its dialect. `frame_colours` reads a data frame. `write_workbook` and
`write_sheets` write workbooks.
"""

from gamutcore.tables.columns import frame_colours
from gamutcore.tables.table import ColourTable, read_table, write_sheets, write_workbook

__all__ = ["ColourTable", "frame_colours", "read_table", "write_sheets", "write_workbook"]
