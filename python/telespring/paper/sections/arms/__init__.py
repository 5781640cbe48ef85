"""The section `arms` of the report."""
