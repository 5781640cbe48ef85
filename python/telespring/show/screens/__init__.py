"""One module per screen that a command prints."""
