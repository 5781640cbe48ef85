"""The section `misprints` of the report."""
