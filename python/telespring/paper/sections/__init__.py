"""The sections of the report, one folder each: numbers and drawings beside the template."""
