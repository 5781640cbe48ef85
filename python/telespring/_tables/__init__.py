"""Tables in text files as instruments, MATLAB, Excel, R and Fortran write them."""

from telespring._tables.reading import TextTable, numbers_from_texts, read_text_table
from telespring._tables.text_lines import read_text

__all__ = ["TextTable", "numbers_from_texts", "read_text", "read_text_table"]
