"""A bridge from the telemetry stream to Lab Streaming Layer (README.md)."""
