"""What a person reads: screens, figures and quantities, from plain results."""
