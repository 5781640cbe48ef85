"""Results of the jobs turned into figures: what to draw is chosen here, how it looks in `figures`."""
