"""The section `laboratory` of the report."""
