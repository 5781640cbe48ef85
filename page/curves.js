// The Nyquist locus of an axis, and its roots as the delay grows.

import { digits, roundUp, time } from "./numbers.js";
import { plane } from "./plane.js";
import { html, pathOf, svg } from "./svg.js";

/** Draws the Nyquist locus into a host. */
export function showNyquist(host, found, axis) {
  const reach = 2.2;
  const width = Math.max(300, Math.min(host.clientWidth || 420, 520));
  const range = { from: -reach, to: reach, factor: 1 };
  const stable = found.unstable_roots === 0;
  const text =
    `${stable ? "No root is unstable" : `${found.unstable_roots} roots are unstable`}. ` +
    (found.gain_margin ? `The loop gain may grow ${digits(found.gain_margin.value, 3, "down")}-fold. ` : "") +
    (found.phase_margin ? `Phase margin ${digits((found.phase_margin.value * 180) / Math.PI, 3, "down")}°. ` : "") +
    (found.delay_margin ? `The delay may grow by ${time(found.delay_margin.value, "down")} each way. ` : "") +
    `The locus comes within ${digits(found.minimum_distance, 3, "down")} of the point −1.`;
  const view = plane({
    width,
    height: width - 20,
    x: { ...range, label: "Real part of the loop L(jω)" },
    y: { ...range, label: "Imaginary part" },
    label: `Nyquist locus, axis ${axis}`,
    description: text,
  });
  const points = found.real.map((real, i) => [view.toX(real), view.toY(found.imaginary[i])]);
  const mirrored = found.real.map((real, i) => [view.toX(real), view.toY(-found.imaginary[i])]);
  const [x, y] = [view.toX(-1), view.toY(0)];
  view.content.append(
    svg("circle", { cx: x, cy: y, r: Math.abs(view.toX(0) - x), class: "unit-circle", transform: `translate(${view.toX(0) - x} 0)` }),
    svg("path", { d: pathOf(mirrored), class: "line mirrored" }),
    svg("path", { d: pathOf(points), class: "line locus" }),
    svg("path", { d: `M${x - 6} ${y}H${x + 6}M${x} ${y - 6}V${y + 6}`, class: "critical" }),
    svg("text", { x: x - 8, y: y - 9, "text-anchor": "end" }, "−1"),
  );
  const rigid = found.rigid_body ? " With free handles the locus starts at −1: both robots drifting together is no instability." : "";
  host.replaceChildren(view.drawing, html("p", { className: "reading" }, text + rigid));
}

/** Draws the rightmost roots over the delay into a host; `delay` is the study's mean one, s. */
export function showRoots(host, found, axis, delay) {
  const roots = found.delays.flatMap((column) => column.roots.map((root) => [...root, column.delay]));
  const near = roots.filter(([real]) => real > -40);
  const width = Math.max(300, Math.min(host.clientWidth || 420, 520));
  const most = Math.max(2, ...near.map(([real]) => real));
  const frequency = roundUp(Math.min(Math.max(10, ...near.filter(([real]) => real > -15).map(([, imaginary]) => imaginary)), 400));
  const longest = found.delays.at(-1).delay;
  const first = found.delays.find((column) => column.roots.some(([real]) => real > 0));
  const text = first
    ? `From a delay of about ${time(first.delay)} on a root lies right of the line: its motion grows.`
    : `Up to ${time(longest)} every root stays left of the line: every motion dies away.`;
  const view = plane({
    width,
    height: width - 20,
    x: { from: -20, to: Math.max(4, 1.2 * Math.min(most, 20)), label: "Growth rate, 1/s (left of 0 dies away)", factor: 1 },
    y: { from: 0, to: frequency, label: "Frequency, rad/s", factor: 1 },
    label: `Roots over the delay, axis ${axis}`,
    description: text,
  });
  view.content.append(svg("rect", { x: view.toX(0), y: view.top, width: 2000, height: view.inner.height, class: "growing" }), svg("path", { d: `M${view.toX(0)} 0V${2000}`, class: "axis-line" }));
  for (const [real, imaginary, at] of roots) {
    const [x, y, r] = [view.toX(real), view.toY(imaginary), 1.2 + 2 * (at / longest)];
    if (Number.isFinite(x)) view.content.append(svg("circle", { cx: x.toFixed(1), cy: y.toFixed(1), r: r.toFixed(2), class: "root" }));
  }
  const own = found.delays.reduce((one, other) => (Math.abs(other.delay - delay) < Math.abs(one.delay - delay) ? other : one));
  for (const [real, imaginary] of own.roots) {
    view.content.append(svg("path", { d: `M${view.toX(real) - 5} ${view.toY(imaginary) - 5}l10 10m0 -10l-10 10`, class: "root-now" }));
  }
  const key = `Dots: the roots from no delay (small) to ${time(longest)} (large). Crosses: at your delay.`;
  host.replaceChildren(view.drawing, html("p", { className: "reading" }, `${text} ${key}`));
}
