"""How to read the report: the meaning of its verdicts and delays, and where its numbers are."""

from telespring.paper.section import Section

__all__ = ["SECTION"]

SECTION = Section(name="reading", anchor="reading", title="How to read this page")
