"""Commands of the program `telespring` that stand in files of their own."""
