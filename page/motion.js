// The motion of the two robots in time: with the bare spring and, beside it, behind the guard.

import { STATE } from "./engine.js";
import { digits, roundUp, time } from "./numbers.js";
import { plane, pointerPlace } from "./plane.js";
import { html, pathOf, svg } from "./svg.js";

/** A pull at robot 1: to this place, m, with this grip, N/m, for so long, s. */
const PULL = { place: 0.02, grip: 200, time: 0.4 };
const LENGTH = 4;
const POINTS = 500;
/** Where the numbers of spring and guard start in a state. */
const RUNS = [
  ["Bare spring", 1],
  ["Guard", 7],
];
const REACH = 0.06;
/** Sample periods that are shown, s: shorter ones take too long to compute, longer ones have no motion to see. */
const PERIODS = { least: 1e-4, most: 0.1 };

/** The motion after a pull at robot 1, and robots that a reader pulls. */
export function createMotion(host) {
  let engine = null;
  let study = null;
  let period = 1e-3;
  let live = null;
  const panels = html("div", { className: "panels" });
  const reading = html("p", { className: "reading" });
  const status = html("p", { className: "reading", role: "status" });
  const stages = RUNS.map(([name]) => createStage(name, (place) => live && (live.place = place), () => begin()));
  const stage = html("div", { className: "stages", hidden: true }, ...stages.map((each) => each.element));
  const runButton = html("button", { type: "button", className: "primary" }, "Move the robots yourself");
  const pullButton = html("button", { type: "button", disabled: true }, "Pull robot 1 and let go");
  host.append(panels, reading, html("div", { className: "buttons" }, runButton, pullButton), status, stage);

  const play = (axis) => {
    engine.start(study, axis, 1);
    const pulled = Math.round(PULL.time / period);
    const rest = Math.round(LENGTH / period);
    return { states: [engine.step(pulled, PULL.place, PULL.grip), engine.step(rest, 0, 0)], pulled, rest };
  };

  /** Draws the motion; returns whether the bare spring's grows. */
  const drawPanels = ({ states }) => {
    const all = states.flatMap((each) => Array.from({ length: each.length / STATE }, (_, i) => each.subarray(i * STATE, (i + 1) * STATE)));
    const stride = Math.max(1, Math.floor(all.length / POINTS));
    const seen = all.filter((_, i) => i % stride === 0);
    const words = [];
    const growing = [];
    const places = all.flatMap((s) => RUNS.flatMap(([, at]) => (s[at + 5] ? [] : [Math.abs(s[at]), Math.abs(s[at + 1])])));
    const reach = Math.min(roundUp(1.1 * Math.max(0.01, places.reduce((one, other) => Math.max(one, other), 0))), REACH);
    const drawings = RUNS.map(([name, at]) => {
      const size = (from, to) => Math.max(0, ...all.filter((s) => s[0] >= from && s[0] < to && !s[at + 5]).map((s) => Math.abs(s[at] - s[at + 1])));
      const [early, late] = [size(PULL.time, PULL.time + 1), size(PULL.time + LENGTH - 1, Infinity)];
      const hasLeft = all.at(-1)[at + 5] === 1;
      const grows = hasLeft || late > 1.05 * early;
      growing.push(grows);
      const text = hasLeft
        ? `${name}: the robots shake each other until they leave the page.`
        : `${name}: the distance between the robots swings by up to ${digits(early * 1e3, 3)} mm in the first second, by ${digits(late * 1e3, 3)} mm in the last: it ${grows ? "grows" : "dies away"}.`;
      words.push(text);
      const view = plane({
        width: Math.max(300, Math.min(panels.clientWidth ? (panels.clientWidth > 700 ? panels.clientWidth / 2 - 8 : panels.clientWidth) : 420, 560)),
        height: 220,
        x: { from: 0, to: PULL.time + LENGTH, label: "Time, s", factor: 1 },
        y: { from: -reach, to: reach, label: "Position, mm", factor: 1e3 },
        label: `Motion after a pull: ${name.toLowerCase()}`,
        description: text,
      });
      view.content.append(svg("rect", { x: view.left, y: view.top, width: view.toX(PULL.time) - view.left, height: view.inner.height, class: "pulled" }));
      for (const [robot, style] of [[0, "robot1"], [1, "robot2"]]) {
        const points = seen.map((s) => (s[at + 5] ? null : [view.toX(s[0]), view.toY(Math.max(-1, Math.min(1, s[at + robot])))]));
        view.content.append(svg("path", { d: pathOf(points), class: `line ${style}` }));
      }
      return html("figure", {}, html("figcaption", {}, name), view.drawing);
    });
    panels.replaceChildren(...drawings);
    reading.textContent = `A hand pulls robot 1 (solid line) by ${PULL.place * 1e3} mm for ${PULL.time} s and lets go; robot 2 (dashed) follows over the network. ${words.join(" ")}`;
    return growing[0];
  };

  const begin = () => {
    if (live) return;
    engine.start(study, live_axis, 2);
    live = { place: null, last: null, pull: 0 };
    stage.hidden = false;
    pullButton.disabled = false;
    runButton.textContent = "Stop";
    status.textContent = "Drag the blue handle of robot 1, or press “Pull robot 1 and let go”. Both couplings feel the same hand.";
    requestAnimationFrame(frame);
  };
  let live_axis = 0;
  const end = () => {
    live = null;
    pullButton.disabled = true;
    runButton.textContent = "Move the robots yourself";
  };
  const frame = (now) => {
    if (!live) return;
    const passed = live.last === null ? 0 : Math.min((now - live.last) / 1e3, 0.1);
    live.last = now;
    live.debt = (live.debt ?? 0) + passed;
    const ticks = Math.floor(live.debt / period);
    live.debt -= ticks * period;
    if (live.pull > 0) live.pull -= passed;
    const isPulled = live.pull > 0;
    const place = isPulled ? PULL.place : live.place;
    if (ticks > 0) {
      const states = engine.step(ticks, place ?? 0, place === null ? 0 : PULL.grip);
      const last = states.subarray(states.length - STATE);
      RUNS.forEach(([, at], i) => stages[i].show(last[at], last[at + 1], place, last[at + 5] === 1));
      if (last[6] === 1 && last[12] === 1) {
        status.textContent = "Both couplings have thrown the robots off the page.";
        return end();
      }
    }
    requestAnimationFrame(frame);
  };
  runButton.addEventListener("click", () => (live ? (end(), (status.textContent = "")) : begin()));
  pullButton.addEventListener("click", () => {
    if (live) live.pull = PULL.time;
  });

  return {
    /** Shows the motion of a study; `isStable` is what the answer says of it, null for neither. */
    show(core, text, axis, samplePeriod, isStable) {
      [engine, study, live_axis] = [core, text, axis];
      if (live) end();
      status.textContent = "";
      const cannot = (why) => {
        panels.replaceChildren();
        reading.textContent = `The motion cannot be shown: ${why}`;
        runButton.disabled = true;
        stage.hidden = true;
      };
      period = samplePeriod > 0 ? samplePeriod : 1e-3;
      if (period < PERIODS.least || period > PERIODS.most) {
        return cannot(`it is computed for sample periods from ${time(PERIODS.least)} to ${time(PERIODS.most)}.`);
      }
      try {
        const grows = drawPanels(play(axis));
        if (isStable !== null && grows === isStable) reading.append(` One pull shows ${LENGTH} s; the answer above is about every pull and all later times.`);
        runButton.disabled = false;
      } catch (error) {
        cannot(error.message);
      }
    },
  };
}

/** A rail with two handles; `pull` is told where the pointer is, m, or null. */
function createStage(name, pull, begin) {
  const width = 600, height = 88, middle = width / 2, scale = width / (2 * REACH * 1.2);
  const drawing = svg("svg", { viewBox: `0 0 ${width} ${height}`, class: "stage", role: "img", "aria-label": `${name}: two robots on a rail, moving` });
  const spring = svg("path", { class: "spring" });
  const hand = svg("line", { class: "hand", y1: 30, y2: 30 });
  const one = svg("rect", { class: "handle1", width: 26, height: 26, y: 17, rx: 5 });
  const two = svg("circle", { class: "handle2", r: 13, cy: 58 });
  drawing.append(svg("path", { d: `M10 30H${width - 10}M10 58H${width - 10}`, class: "rail" }), spring, hand, one, two);
  const label = svg("text", { x: 12, y: 16 }, name);
  drawing.append(label);
  const show = (x1, x2, place, hasEnded) => {
    const at = (x) => Math.max(-40, Math.min(width + 40, middle + scale * x));
    one.setAttribute("x", at(x1) - 13);
    two.setAttribute("cx", at(x2));
    spring.setAttribute("d", `M${at(x1)} 34L${at(x2)} 54`);
    hand.setAttribute("x1", place === null ? at(x1) : at(place));
    hand.setAttribute("x2", at(x1));
    label.textContent = hasEnded ? `${name}: the robots have left the page` : name;
  };
  show(0, 0, null, false);
  const follow = (event) => pull((pointerPlace(drawing, event)[0] - middle) / scale);
  drawing.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    begin();
    drawing.setPointerCapture(event.pointerId);
    follow(event);
    drawing.addEventListener("pointermove", follow);
    const release = () => {
      drawing.removeEventListener("pointermove", follow);
      pull(null);
    };
    drawing.addEventListener("pointerup", release, { once: true });
    drawing.addEventListener("pointercancel", release, { once: true });
  });
  return { element: drawing, show };
}
