"""The section `number_sets` of the report."""
