"""Tables: one value that every command's tables have, and the forms in which it is written.

Headings, units, rounded texts and exact values are together in a `ResultTable`; the modules beside it write
it for the terminal, Markdown, LaTeX, CSV, JSON and notebooks. No command formats a table by itself.
"""

from prp_gym.tables.cell import ABSENT, Cell
from prp_gym.tables.column import TableColumn
from prp_gym.tables.result_table import ResultTable

__all__ = ["ABSENT", "Cell", "ResultTable", "TableColumn"]
