"""The paper on a study's robots: numbers, figures, and one page that holds both.

`analyse` computes, `write` puts `report.html` and `study.json` into a folder. The keys of
`study.json` are listed in `docs/study-json.md`; everything in it is in SI units unless its row there
says otherwise, and a value that is infinite or does not exist is null.

Each part of the paper is a module with functions from `Scene` to `Found`; `PARTS` lists them.
"""

from telespring.paper.reproduce import PARTS, STEPS, Analysis, analyse, write
from telespring.paper.scene import Found, Part, Scene

__all__ = ["PARTS", "STEPS", "Analysis", "Found", "Part", "Scene", "analyse", "write"]
