"""The section `model` of the report."""
