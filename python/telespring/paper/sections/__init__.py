"""The sections of the report: in each folder `section.py` computes and `page.html.jinja` shows it."""

from telespring.paper.section import Section
from telespring.paper.sections.arms.section import SECTION as ARMS
from telespring.paper.sections.calibration.section import SECTION as CALIBRATION
from telespring.paper.sections.comparison.section import SECTION as COMPARISON
from telespring.paper.sections.examples.section import SECTION as EXAMPLES
from telespring.paper.sections.experiment.section import SECTION as EXPERIMENT
from telespring.paper.sections.explore.section import SECTION as EXPLORE
from telespring.paper.sections.frequency.section import SECTION as FREQUENCY
from telespring.paper.sections.identification.section import SECTION as IDENTIFICATION
from telespring.paper.sections.laboratory.section import SECTION as LABORATORY
from telespring.paper.sections.map.section import SECTION as MAP
from telespring.paper.sections.misprints.section import SECTION as MISPRINTS
from telespring.paper.sections.model.section import SECTION as MODEL
from telespring.paper.sections.number_sets.section import SECTION as NUMBER_SETS
from telespring.paper.sections.nyquist.section import SECTION as NYQUIST
from telespring.paper.sections.reading.section import SECTION as READING
from telespring.paper.sections.responses.section import SECTION as RESPONSES
from telespring.paper.sections.robots.section import SECTION as ROBOTS
from telespring.paper.sections.summary.section import SECTION as SUMMARY

__all__ = ["SECTIONS", "order_of_computation"]

#: In the order on the page: that of the paper, with additional sections next to related ones.
SECTIONS = (
    SUMMARY,
    MODEL,
    ROBOTS,
    MAP,
    EXPLORE,
    NYQUIST,
    FREQUENCY,
    RESPONSES,
    LABORATORY,
    EXPERIMENT,
    CALIBRATION,
    ARMS,
    COMPARISON,
    NUMBER_SETS,
    IDENTIFICATION,
    EXAMPLES,
    MISPRINTS,
    READING,
)


def order_of_computation(sections: tuple[Section, ...]) -> tuple[Section, ...]:
    """Sort the sections that compute something into the order in which they do, from that on the page."""
    ordered = [section for section in sections if section.find and not section.computed_after]
    for section in sections:
        if section.find and section.computed_after:
            names = [other.name for other in ordered]
            ordered.insert(names.index(section.computed_after) + 1, section)
    return tuple(ordered)
