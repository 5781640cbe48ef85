"""The section `robots` of the report."""
