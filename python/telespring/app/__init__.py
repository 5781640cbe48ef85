"""The interactive page: opened by the command `explore`, inside the report, and shown in notebooks."""
