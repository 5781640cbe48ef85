"""One file per peer: the same question, asked the way its documentation does."""
