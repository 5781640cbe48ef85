// The answer: in one word, by what margin, and by kind of network.

import { stiffness, time, unbounded } from "./numbers.js";
import { html, svg } from "./svg.js";
import { MEANING, TIERS, WORDS, delayName, isVarying, limits, marginSentence, notes, questionSentence, worseOf } from "./words.js";

const SIGNS = {
  stable: "M24 4a20 20 0 1 0 0 40a20 20 0 1 0 0-40ZM14 24l7 8l14-16",
  marginal: "M24 5L45 42H3ZM24 17V29M24 34.5V37",
  unstable: "M15 4H33L44 15V33L33 44H15L4 33V15ZM16 16L32 32M32 16L16 32",
  "not proven": "M24 3L45 24L24 45L3 24ZM18 19a6 6 0 1 1 8 6c-2 1-2 2-2 4M24 34V36",
};

/** The word, what was asked, and the margins. */
export function showAnswer(host, values, answer) {
  const decided = worseOf(answer);
  const { status } = decided;
  const sign = svg("svg", { viewBox: "0 0 48 48", class: "sign", "aria-hidden": "true" }, svg("path", { d: SIGNS[status] }));
  const cases = !answer.free
    ? ""
    : answer.free.status !== answer.status
      ? ` With the hands ${WORDS[answer.status].toLowerCase()}, with free handles ${WORDS[answer.free.status].toLowerCase()}.`
      : " So it is with the hands and with free handles; the limits hold for both.";
  const at = limits(decided);
  const delay = decided.constant_delay.mean;
  host.dataset.status = status.replace(" ", "-");
  host.replaceChildren(
    html("div", { className: "word" }, sign, html("p", { className: "verdict", id: "verdict" }, WORDS[status])),
    html("p", { className: "asked" }, questionSentence(values)),
    html("p", { className: "meaning" }, MEANING[status] + cases),
    html("p", { className: "margin", id: "margin" }, marginSentence(values, decided)),
    html(
      "div",
      { className: "meters" },
      meter(isVarying(decided) ? "Stiffness, of what is proven" : "Stiffness, of the most at this delay", values.stiffness, at.stiffness, stiffness, isVarying(decided) ? "no stiffness is proven" : "no stiffness is known to be stable"),
      meter(`${sentenceCase(delayName(decided))}, of the most at this stiffness`, delay, at.delay, time, "no delay above 0 is stable"),
    ),
    ...notes(values).map((note) => html("p", { className: "note" }, note)),
  );
}

const sentenceCase = (text) => text[0].toUpperCase() + text.slice(1);

/** How much of a limit is used: a bar that is full at the limit; `none` says what a limit of 0 means. */
function meter(label, value, limit, write, none) {
  const share = limit === 0 ? 2 : Number.isFinite(limit) ? value / limit : 0;
  const end = 0.8;
  const bar = svg(
    "svg",
    { viewBox: "0 0 200 14", preserveAspectRatio: "none", class: share >= 1 ? "bar beyond" : "bar", "aria-hidden": "true" },
    svg("rect", { x: 0, y: 4, width: 200, height: 6, rx: 3, class: "track" }),
    svg("rect", { x: 0, y: 4, width: Math.min(share * end, 1) * 200, height: 6, rx: 3, class: "fill" }),
    svg("rect", { x: 200 * end - 1, y: 0, width: 2, height: 14, class: "end" }),
  );
  const text = limit === 0 ? `${write(value)}; ${none}` : `${write(value)} of ${Number.isFinite(limit) ? write(limit, "down") : "no limit"}`;
  return html("div", { className: "meter" }, html("p", {}, html("span", {}, label), html("strong", {}, text)), bar);
}

const MET = { met: "yes", "met behind playout buffer": "only behind a play-out buffer", "not met": "no" };

const tick = (is) => html("span", { className: is ? "yes" : "no" }, is ? "✓ yes" : "✗ no");

/** What the paper's rule says beside its stiffness, and whether it is right here. */
function paperMeaning(decided, paper) {
  const delay = paper.maximum_delay === null ? "" : `, or a delay below ${time(paper.maximum_delay, "down")} at your stiffness`;
  return `Eqs. 5 to 9: a stiffness up to that of Eq. 5${delay}. ${decided.paper_agrees ? "Here it agrees." : "Here its formulas are wrong."}`;
}

/** The five verdicts and the paper's, as a table. */
export function showVerdicts(host, values, answer) {
  const decided = worseOf(answer);
  const held = answer.free ? [answer, answer.free] : [answer];
  const rows = TIERS.map(([key, name, meaning]) => {
    const all = held.map((each) => each.verdicts[key]);
    const isAvailable = all.every((each) => each.available);
    const bounds = all.map((each) => (each.stiffness_limit === null && !each.stiffness_unbounded ? unbounded(each.stiffness_allowed, each.stiffness_unbounded) : each.stiffness_limit ?? Infinity));
    const least = Math.min(...bounds.map((bound) => bound ?? 0));
    return html(
      "tr",
      {},
      html("th", { scope: "row" }, name, html("span", { className: "meaning" }, meaning)),
      html("td", { className: "number" }, isAvailable ? stiffness(least, "down") : "no rule"),
      html("td", {}, isAvailable ? tick(all.every((each) => each.satisfied)) : "–"),
      html("td", {}, MET[decided.verdicts[key].assumption]),
    );
  });
  const { paper } = decided.verdicts;
  rows.push(
    html(
      "tr",
      { className: "paper-row" },
      html("th", { scope: "row" }, "the paper's own rule", html("span", { className: "meaning" }, paperMeaning(decided, paper))),
      html("td", { className: "number" }, paper.stiffness_allowed === null ? "no rule" : stiffness(paper.stiffness_allowed, "down")),
      html("td", {}, tick(paper.satisfied)),
      html("td", {}, "–"),
    ),
  );
  host.replaceChildren(
    html(
      "table",
      {},
      html("caption", {}, "The stiffness up to which all is stable, by what the network may do. Less trust in the network means a softer spring."),
      html("thead", {}, html("tr", {}, ...["If the network has …", "stiffness up to", "yours is stable", "yours is such a network"].map((text) => html("th", { scope: "col" }, text)))),
      html("tbody", {}, ...rows),
    ),
  );
}
