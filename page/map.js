// The map: what is stable over stiffness and delay, with the study's own point, which can be dragged.

import { roundUp, stiffness, time } from "./numbers.js";
import { plane, pointerPlace } from "./plane.js";
import { html, pathOf, svg } from "./svg.js";
import { WORDS, isVarying, limits, marginSentence, worseOf } from "./words.js";

const COLUMNS = 500;
/** Delays at which the verdicts while the delay varies are judged. */
const ROWS = 40;

/** How far a map shows, N/m and s: the point and, as far as they are near, its limits. */
export function mapExtent(values, answer) {
  const at = limits(worseOf(answer));
  const delay = (values.delay[0] + values.delay[1]) / 2;
  const near = (limit, own, most) => (Number.isFinite(limit) ? Math.min(limit, most * own) : 0);
  return {
    stiffness: roundUp(Math.max(1.5 * values.stiffness, 1.3 * near(at.constantStiffness, values.stiffness, 20))),
    delay: roundUp(Math.max(1.5 * delay, 1.3 * near(at.delay, Math.max(delay, 0.02), 6), 0.02)),
  };
}

/** The strips of a map's stable intervals as one path. */
function strips(found, view) {
  let path = "";
  let before = 0;
  found.stiffness.forEach((k, column) => {
    for (const [start, end] of found.stable[column]) {
      const [x0, x1, y0, y1] = [view.toX(before), view.toX(k) + 0.2, view.toY(start), view.toY(Math.min(end, 1e3))];
      path += `M${x0.toFixed(2)} ${y0.toFixed(2)}V${Math.max(y1, -50).toFixed(2)}H${x1.toFixed(2)}V${y0.toFixed(2)}Z`;
    }
    before = k;
  });
  return path;
}

/** The map of a study; `move` is called with a stiffness and a mean delay that the reader chooses. */
export function createMap(host, { move, settle }) {
  let shown = null;
  let view = null;
  const legend = html("ul", { className: "legend" });
  const place = html("div", { className: "map-place" });
  host.append(place, legend);
  const point = svg("g", { class: "point", tabindex: "0", role: "button" });

  const draw = (values, answer, found, extent, bands, attacks) => {
    const hadFocus = document.activeElement === point;
    const width = Math.max(320, Math.min(place.clientWidth || 640, 900));
    view = plane({
      width,
      height: Math.round(Math.min(0.72 * width + 40, 460)),
      x: { from: 0, to: extent.stiffness, label: "Stiffness of the spring, N/m", factor: 1 },
      y: { from: 0, to: extent.delay, label: values.delay[0] === values.delay[1] ? "Delay each way, ms" : "Mean delay of both ways, ms", factor: 1e3 },
      label: "Map of what is stable",
      description: describe(values, answer),
    });
    const varying = isVarying(answer);
    view.content.append(svg("path", { d: strips(found, view), class: varying ? "stable-buffered" : "stable-region" }));
    const keys = [[varying ? "stable-buffered" : "stable-region", "area", varying ? "stable if a buffer makes the delay constant" : "stable at a constant delay"]];
    const line = (of) => {
      const points = bands.map((band) => [view.toX(Math.min(of(band), 2 * extent.stiffness)), view.toY(band.delay)]);
      return pathOf(points);
    };
    if (varying && bands.length <= 1) keys.unshift(["", "none", "what is proven while the delay varies: still computed …"]);
    if (varying && bands.length > 1) {
      const end = bands.map((band) => [view.toX(Math.min(band.allowed ?? Infinity, 2 * extent.stiffness)), view.toY(band.delay)]);
      const region = `${pathOf([[view.toX(0), view.toY(bands[0].delay)], ...end, [view.toX(0), view.toY(bands.at(-1).delay)]])}Z`;
      view.content.append(svg("path", { d: region, class: "stable-region" }), svg("path", { d: line((band) => band.allowed ?? Infinity), class: "line proven" }));
      view.content.append(svg("path", { d: line((band) => band.bounded_varying_delay ?? Infinity), class: "line bounded" }));
      keys.unshift(["stable-region", "area", "stable however the delay varies: proven"]);
      keys.push(["line proven", "line", "limit of what is proven (an age in a range)"], ["line bounded", "line", "limit by the bound on the age alone"]);
      const seen = attacks.filter((attack) => attack.stiffness !== null);
      if (seen.length) {
        const places = seen.map((attack) => [view.toX(attack.stiffness), view.toY(attack.delay)]);
        view.content.append(svg("path", { d: pathOf(places), class: "line attack" }));
        for (const [x, y] of places) view.content.append(svg("path", { d: `M${x - 4} ${y - 4}L${x + 4} ${y + 4}M${x - 4} ${y + 4}L${x + 4} ${y - 4}`, class: "attack-mark" }));
        keys.push(["line attack", "line", "an attack was found that makes the motion grow from here on; between it and what is proven nobody knows"]);
      }
    }
    // At one stiffness the sign in Eq. 9 is 0, and with it the delay: a place of no width is no line.
    const isPlace = (i) => found.paper[i] === 0 && found.paper[i - 1] > 0 && found.paper[i + 1] > 0;
    const paper = found.stiffness.flatMap((k, i) => (isPlace(i) ? [] : found.paper[i] === null ? [null] : [[view.toX(k), view.toY(Math.max(found.paper[i] - found.extra, 0))]]));
    if (paper.some(Boolean)) {
      const critical = found.paper_critical;
      const from = critical > 0 && critical < extent.stiffness ? [[view.toX(critical), view.toY(extent.delay * 1.2)]] : [];
      view.content.append(svg("path", { d: pathOf([...from, ...paper]), class: "line paper" }));
      keys.push(["line paper", "line", "the paper's boundary (Eqs. 5 to 9), for comparison"]);
    }
    view.above.append(point);
    moveTo(values, answer);
    wire(view.drawing);
    place.replaceChildren(view.drawing);
    keys.push(["point-key", "star", "your study: drag it, or use the arrow keys"]);
    legend.replaceChildren(...keys.map(([style, kind, text]) => html("li", {}, swatch(style, kind), text)));
    if (hadFocus) point.focus();
  };

  const moveTo = (values, answer) => {
    const delay = (values.delay[0] + values.delay[1]) / 2;
    const [x, y] = [view.toX(values.stiffness), view.toY(delay)];
    const word = WORDS[worseOf(answer).status];
    point.setAttribute("transform", `translate(${x.toFixed(2)} ${y.toFixed(2)})`);
    point.setAttribute("aria-label", `${word}: ${stiffness(values.stiffness)}, ${time(delay)}. The arrow keys move this point.`);
    const toLeft = x > view.left + 0.62 * view.inner.width;
    const above = y > view.top + 24;
    point.replaceChildren(
      svg("circle", { r: 16, class: "halo" }),
      svg("path", { d: star(9), class: "star" }),
      svg("text", { x: toLeft ? -14 : 14, y: above ? -8 : 18, "text-anchor": toLeft ? "end" : "start", class: "point-word" }, word),
    );
    view.about.textContent = describe(values, answer);
  };

  const wire = (drawing) => {
    const follow = (event) => {
      const [k, delay] = view.invert(...pointerPlace(drawing, event));
      move(Math.max(k, 0.1), Math.max(delay, 0));
    };
    drawing.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      drawing.setPointerCapture(event.pointerId);
      point.focus({ preventScroll: true });
      follow(event);
      drawing.addEventListener("pointermove", follow);
      const end = () => {
        drawing.removeEventListener("pointermove", follow);
        settle();
      };
      drawing.addEventListener("pointerup", end, { once: true });
      drawing.addEventListener("pointercancel", end, { once: true });
    });
  };
  point.addEventListener("keydown", (event) => {
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!steps || !shown) return;
    event.preventDefault();
    const share = event.shiftKey ? 0.05 : 0.01;
    const { values, extent } = shown;
    const delay = (values.delay[0] + values.delay[1]) / 2;
    move(Math.max(values.stiffness + steps[0] * share * extent.stiffness, 0.1), Math.max(delay + steps[1] * share * extent.delay, 0));
    settle();
  });

  return {
    /** Draws all anew, or only moves the point where the rest is the same. */
    show(values, answer, found, extent, bands, attacks) {
      const isSame = shown && shown.found === found && shown.bands === bands && shown.attacks === attacks && shown.varying === isVarying(answer) && shown.width === place.clientWidth;
      shown = { values, answer, found, extent, bands, attacks, varying: isVarying(answer), width: place.clientWidth };
      if (isSame) moveTo(values, answer);
      else draw(values, answer, found, extent, bands, attacks);
    },
    drawing: () => view?.drawing ?? null,
  };
}

function describe(values, answer) {
  const delay = (values.delay[0] + values.delay[1]) / 2;
  const decided = worseOf(answer);
  return (
    `Stiffness to the right, delay upwards; the shaded area is stable. Your study, ${stiffness(values.stiffness)} and ${time(delay)}, is ` +
    `${WORDS[decided.status].toLowerCase()}. ${marginSentence(values, decided)}`
  );
}

function star(radius) {
  const corner = (i) => {
    const r = i % 2 ? 0.42 * radius : radius;
    const angle = (Math.PI * i) / 5 - Math.PI / 2;
    return [r * Math.cos(angle), r * Math.sin(angle)];
  };
  return `${pathOf(Array.from({ length: 10 }, (_, i) => corner(i)))}Z`;
}

function swatch(style, kind) {
  const mark = {
    none: () => svg("g"),
    area: () => svg("rect", { x: 1, y: 2, width: 24, height: 12, class: style }),
    line: () => svg("path", { d: "M1 8H25", class: style }),
    star: () => svg("path", { d: star(7), transform: "translate(13 8)", class: "star" }),
  }[kind]();
  return svg("svg", { viewBox: "0 0 26 16", width: 26, height: 16, "aria-hidden": "true" }, mark);
}

/** The columns of a map. */
export const readMap = (engine, study, extent, isSlow) => engine.map(study, extent.stiffness, extent.delay, isSlow ? 60 : COLUMNS);

/** The delays at which the verdicts on a varying delay are asked. */
export const bandDelays = (extent) => Array.from({ length: ROWS + 1 }, (_, row) => (1.02 * extent.delay * row) / ROWS);
