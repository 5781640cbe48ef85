"""The section `map` of the report."""
