"""Study and robot files: read, edited and written; the names of conditions."""
