"""The section `responses` of the report."""
