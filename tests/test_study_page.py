"""The page of a study: every number of it is in `study.json`, and says what it holds for."""

import json
import re
from html.parser import HTMLParser

import pytest

import telespring as ts
from telespring.paper import Analysis
from telespring.paper.page import look_up, places_of
from telespring.paper.sections import SECTIONS
from telespring.show.quantities import Style, format_quantity


class Page(HTMLParser):
    """The `<data>` elements, what would be loaded, and the running text outside of figures."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.data: list[tuple[str, str, str]] = []
        self.loaded: list[str] = []
        self.identifiers: list[str] = []
        self.open: list[str] = []
        self.prose: list[str] = []
        self.current: tuple[str, str] | None = None
        self.sentences: list[tuple[str, str]] = []
        self.sentence: str | None = None
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag in {"link", "img", "iframe", "object", "embed", "video", "audio"}:
            self.loaded.append(tag)
        for name in ("src", "href", "xlink:href"):
            if given.get(name) and not str(given[name]).startswith("#"):
                self.loaded.append(str(given[name]))
        if given.get("id"):
            self.identifiers.append(str(given["id"]))
        if tag in {"svg", "style", "data", "script"}:
            self.open.append(tag)
        self.sentence = given.get("data-text-key") or self.sentence
        if tag == "data":
            self.current = (str(given["data-key"]), given["value"] or "")

    def handle_endtag(self, tag: str) -> None:
        if tag in {"li", "p"}:
            self.sentence = None
        if self.open and self.open[-1] == tag:
            self.open.pop()

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "data" and self.current is not None:
            self.data.append((*self.current, data))
        elif self.sentence is not None:
            self.sentences.append((self.sentence, data))
        elif not self.open:
            self.prose.append(data)


def test_law_the_page_says_what_its_limits_hold_for(analysis: Analysis, held: Analysis) -> None:
    def part(found: Analysis, start: str, end: str) -> str:
        begin = found.html.index(start)
        return " ".join(re.sub(r"<[^>]+>", "", found.html[begin : found.html.index(end, begin)]).split())

    caption = part(held, '<table id="allowed">', "</caption>")
    for words in (
        "playout buffer",
        "jitter 10 ms",
        "longest gap 4 ms",
        "sample period 2 ms",
        "computing time 0.5 ms",
        "64 ms in the marked row",
        "66.5 ms in the marked row",
        "sampled controllers allow less",
        "worst over them",
    ):
        assert words in caption, words
    assert not re.search(r"[.)][A-Z“]", caption)
    middle = "operators in the middle of their ranges"
    assert middle in part(held, '<h2 id="robots">', "</caption>")
    assert middle in part(held, "<b>Map A.</b>", "</figcaption>")
    assert "the worst over the ranges" in part(held, "<b>Map A.</b>", "</figcaption>")
    assert middle in part(held, '<h2 id="figure5">', "</p>")
    assert middle not in analysis.html
    assert "playout buffer (" not in part(analysis, '<table id="allowed">', "</caption>")


def test_law_a_limit_that_is_shown_lies_within_the_limit(analysis: Analysis, held: Analysis) -> None:
    shown_in = {"N/m": 1.0, "ms": 1e-3}
    for found in (analysis, held):
        limits = [
            each
            for each in Page(found.html).data
            if re.match(r"summary\.rows\.\d+\..*\.stiffness", each[0])
            or re.match(r"axes\.\d+\.(critical|maximum_delay\.\d+\.delay)", each[0])
        ]
        assert len(limits) > 28
        for key, value, shown in limits:
            if value:
                number, unit = shown.split(" ")
                # 1e-15: the product with the unit is rounded
                assert float(number) * shown_in[unit] <= float(value) * (1 + 1e-15), key


def test_law_masses_are_shown_as_they_were_given(analysis: Analysis) -> None:
    shown = {key: text for key, _, text in Page(analysis.html).data}
    assert [shown[f"study.axes.{i}.mass.{side}"] for i in (0, 1) for side in (0, 1)] == [
        "0.8334 kg",
        "0.7776 kg",
        "1.0649 kg",
        "1.3407 kg",
    ]
    assert shown["study.axes.0.damping.0"] == "7.7257 N·s/m"
    assert shown["table3.M"] == "0.8334 kg"


def test_law_the_first_lines_answer_for_the_study_itself(analysis: Analysis) -> None:
    start = analysis.html.index('id="summary"')
    answer = Page(analysis.html[start : analysis.html.index("</section>", start)])
    keys = {key for key, _, _ in answer.data}
    row = f"summary.rows.{analysis.numbers['summary']['highlight']}"
    assert look_up(analysis.numbers, f"{row}.delay") == 0.167
    # the paper's own condition: 2K at Δ, to three digits
    assert analysis.numbers["summary"]["answer"]["status"] == "marginal"
    assert {"summary.answer.stiffness_to_spare", "summary.answer.delay_to_spare"} <= keys
    tiers = ("constant_delay", "any_constant_delay", "bounded_varying_delay", "any_network")
    assert {f"{row}.{tier}.stiffness" for tier in tiers} <= keys
    assert "axis x" in "".join(answer.prose)


def test_law_every_number_of_the_page_is_in_study_json(analysis: Analysis) -> None:
    numbers = json.loads(json.dumps(analysis.numbers, allow_nan=False))
    page = Page(analysis.html)
    assert len(page.data) > 300
    for key, value, shown in page.data:
        stored = look_up(numbers, key)
        if stored is None:
            assert value == ""
            assert shown == "no limit"
        else:
            assert float(value) == stored
    for key, text in page.sentences:
        assert look_up(numbers, key) == text
    # Outside of <data> no measured number stands: only names such as 2K, −180° and Eq. 5, and formulas.
    prose = re.sub(r"0\.5[KMBΔ]|4[KMBΔ]", "", " ".join(page.prose)).replace(ts.__version__, "")
    allowed = {f"{k:g}" for k in (0.5, 0.99, 0.6)}
    assert set(re.findall(r"\d+\.\d+", prose)) <= allowed


def test_law_page_is_self_contained_and_holds_every_figure(analysis: Analysis) -> None:
    page = Page(analysis.html)
    # a picture inside of a figure stands in the page itself
    assert [each for each in page.loaded if not each.startswith("data:")] == []
    assert "http:" not in analysis.html
    assert "https:" not in analysis.html
    assert "@import" not in analysis.html
    drawn = (
        *("dyad", "loop", "map", "nyquist", "frequency", "responses", "laboratory", "trajectories"),
        *("tracking", "calibration", "arms", "delays", "plane", "account", "excitation", "regression"),
        *("residuals1", "residuals2", "examples"),
    )
    assert analysis.html.count("<svg ") == len(drawn)
    for name in drawn:
        assert f'aria-labelledby="{name}-title {name}-description"' in analysis.html
    assert len(page.identifiers) == len(set(page.identifiers))


@pytest.mark.parametrize(
    ("value", "unit", "digits", "style", "text"),
    [
        (0.16718632, "s", 4, "nearest", "167.2 ms"),
        (0.16718632, "s", 4, "limit", "167.1 ms"),
        (0.029, "s", 4, "limit", "29 ms"),
        (0.8334, "kg", 6, "given", "0.8334 kg"),
        (0.8334, "kg", 5, "nearest", "0.83340 kg"),
        (1.2345678, "kg", 6, "given", "1.23457 kg"),
        (120.0, "kg", 2, "given", "120 kg"),
        (0.0156617, "m/N", 4, "nearest", "15.66 mm/N"),
        (36.0, "N/m", 2, "nearest", "36 N/m"),
        (0.3, "rad", 3, "nearest", "17.2°"),
        (-5.3e-14, "1/s", 4, "nearest", "−5.3·10⁻¹⁴ 1/s"),
        (2.99e6, "N/m", 4, "limit", "2.9·10⁶ N/m"),
        (-0.0, "s", 4, "nearest", "0 ms"),
        (None, "s", 4, "nearest", "no limit"),
    ],
)
def test_law_quantities_as_a_person_reads_them(
    value: float | None, unit: str, digits: int, style: Style, text: str
) -> None:
    assert format_quantity(value, unit, digits, style=style) == text


def test_law_every_place_of_the_paper_and_every_section_is_where_the_page_says(analysis: Analysis) -> None:
    identifiers = set(Page(analysis.html).identifiers)
    links = re.findall(r'<a href="#([^"]+)"', analysis.html)
    assert set(links) <= identifiers
    for section in SECTIONS:
        assert section.anchor in identifiers, section.name
    # the paper's ten figures and three tables, each once
    numbered = [f"Fig. {i}" for i in range(1, 11)] + [f"Table {i}" for i in ("I", "II", "III")]
    places = places_of(SECTIONS)
    assert [place.name for place in places] == numbered
    for place in places:
        assert place.anchor in identifiers, place.name
        assert place.anchor in links, place.name


def test_law_table_ii_stands_beside_the_printed_one_with_its_misprint(analysis: Analysis) -> None:
    start = analysis.html.index('<table id="number-sets">')
    table = analysis.html[start : analysis.html.index("</table>", start)]
    # five rows of five sets, none of which differs from the printed one
    assert table.count('class="same"') == 25
    assert 'class="differs"' not in table
    shown = {key for key, _, _ in Page(analysis.html).data}
    assert {"table2.sign_change.ours", "table2.sign_change.printed", "table2.between.eta2"} <= shown
