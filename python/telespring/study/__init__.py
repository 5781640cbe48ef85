"""Study and robot files: edited and read; names of conditions; the target of a task."""
