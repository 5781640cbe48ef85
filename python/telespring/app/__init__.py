"""The interactive page: opened by the command `explore`, and shown in notebooks."""
