"""The section `explore` of the report."""
