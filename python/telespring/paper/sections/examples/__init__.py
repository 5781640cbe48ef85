"""The section `examples` of the report."""
