"""The section `comparison` of the report."""
