"""The section `experiment` of the report."""
