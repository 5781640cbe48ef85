"""The section `frequency` of the report."""
