"""Reproduction of Du et al. (2025) for a study's robots: numbers, figures, and one page that holds both.

`analyse` computes, `write` puts `report.html` and `study.json` into a folder. The keys of `study.json` are
listed in `docs/study-json.md`. Everything in it is in SI units unless its row there says otherwise; a value
that is infinite or does not exist is null.

The report consists of sections, one folder each in `telespring.paper.sections`.
"""

from telespring.paper.reproduce import PARTS, QUICK_PARTS, STEPS, Analysis, analyse, write
from telespring.paper.scene import Scene
from telespring.paper.section import Findings, Section

__all__ = ["PARTS", "QUICK_PARTS", "STEPS", "Analysis", "Findings", "Scene", "Section", "analyse", "write"]
