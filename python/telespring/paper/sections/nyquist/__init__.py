"""The section `nyquist` of the report."""
