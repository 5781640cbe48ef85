"""Tables in text files as instruments, MATLAB, Excel, R and Fortran write them."""

from telespring._tables.reading import TextTable, numbers_from_texts, read_text_table

__all__ = ["TextTable", "numbers_from_texts", "read_text_table"]
