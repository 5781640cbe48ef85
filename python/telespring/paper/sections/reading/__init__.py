"""The section `reading` of the report."""
