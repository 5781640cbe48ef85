"""The section `identification` of the report."""
