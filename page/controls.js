// The controls: each value by a slider and by a number with its unit.

import { clean, digits } from "./numbers.js";
import { html } from "./svg.js";

const STEPS = 1000;

/** A slider's way from places to values: straight, or by decades with 0 at its start. */
function scaleOf({ from, to, isLog }) {
  if (!isLog) return { value: (place) => from + (to - from) * place, place: (value) => (value - from) / (to - from) };
  const hasZero = from === 0;
  const least = hasZero ? isLog : from;
  const start = hasZero ? 1 / STEPS : 0;
  const span = Math.log(to / least);
  return {
    value: (place) => (hasZero && place <= 0 ? 0 : least * Math.exp((span * Math.max(place - start, 0)) / (1 - start))),
    place: (value) => (value <= 0 ? 0 : start + (1 - start) * (Math.log(Math.max(value, least) / least) / span)),
  };
}

/** One value: `of` reads it from the study's values, `change` writes it as a TOML table; shown is the value times `factor`. */
function control(definition, change) {
  const { id, label, unit, factor = 1, hint } = definition;
  const scale = scaleOf(definition);
  const number = html("input", { type: "number", id, step: "any", min: "0", inputMode: "decimal" });
  const slider = html("input", { type: "range", min: "0", max: String(STEPS), step: "1", "aria-label": `${label}, slider` });
  const hintId = `${id}-hint`;
  if (hint) number.setAttribute("aria-describedby", hintId);
  const show = (value) => {
    if (document.activeElement !== number) number.value = String(clean(value * factor));
    // rounded, its own place may be where it came from: no key would move it
    if (document.activeElement !== slider) slider.value = String(Math.round(scale.place(value) * STEPS));
    slider.setAttribute("aria-valuetext", `${digits(value * factor)} ${unit}`);
  };
  slider.addEventListener("input", () => {
    const value = Number(digits(scale.value(Number(slider.value) / STEPS) * factor, 3));
    number.value = String(value);
    slider.setAttribute("aria-valuetext", `${value} ${unit}`);
    change(definition, clean(value / factor), false);
  });
  slider.addEventListener("change", () => change(definition, null, true));
  number.addEventListener("input", () => {
    if (number.value !== "" && Number.isFinite(number.valueAsNumber)) change(definition, clean(number.valueAsNumber / factor), false);
  });
  number.addEventListener("change", () => change(definition, null, true));
  const element = html(
    "div",
    { className: "control" },
    html("label", { htmlFor: id }, label),
    html("span", { className: "value" }, number, html("span", { className: "unit" }, unit)),
    slider,
    hint ? html("p", { className: "hint", id: hintId }, hint) : null,
  );
  return { element, show: (values) => show(definition.of(values)) };
}

const list = (values) => `[${values.join(", ")}]`;
const withAt = (values, at, value) => values.map((own, i) => (i === at ? value : own));

/** Delay or jitter of one way, or of both where they are the same. */
const ways = (key, values, at, value) =>
  at === null ? `network.${key} = ${value}` : `network.${key} = {forward = ${at === 0 ? value : values[key][0]}, backward = ${at === 1 ? value : values[key][1]}}`;

/** The groups of controls for a study's axes. */
function groups(values) {
  const { usual, axes } = values;
  const coupling = [
    { id: "stiffness", label: "Stiffness of the spring", unit: "N/m", from: 1, to: 2000, isLog: 1, of: (v) => v.stiffness, toml: (_, k) => `coupling.stiffness = ${k}`, hint: "How hard the virtual spring pulls the two robots together." },
    ...(values.delay[0] === values.delay[1]
      ? [{ id: "delay", label: "Delay each way", unit: "ms", factor: 1e3, from: 0, to: 1, isLog: 1e-3, of: (v) => v.delay[0], toml: (v, d) => ways("delay", v, null, d), hint: "From the measurement of a position to its use at the partner; about half a ping." }]
      : [0, 1].map((way) => ({ id: `delay-${way + 1}`, label: way === 0 ? "Delay, robot 1 to 2" : "Delay, robot 2 to 1", unit: "ms", factor: 1e3, from: 0, to: 1, isLog: 1e-3, of: (v) => v.delay[way], toml: (v, d) => ways("delay", v, way, d) }))),
    { id: "jitter", label: "Jitter", unit: "ms", factor: 1e3, from: 0, to: 0.3, isLog: 1e-3, of: (v) => Math.max(...v.jitter), toml: (v, j) => ways("jitter", v, null, j), hint: "By how much longer a packet may take than the delay." },
    { id: "sample-period", label: "Sample period of the controllers", unit: "ms", factor: 1e3, from: 0, to: usual.sample_period[1], isLog: 1e-4, of: (v) => v.sample_period, toml: (_, h) => `controller.sample_period = ${h}`, hint: "0 is a continuous controller; a 1 kHz controller has 1 ms." },
  ];
  const robot = (i) =>
    axes.flatMap((axis, at) => {
      const on = axes.length > 1 ? `, axis ${axis}` : "";
      return [
        { id: `mass-${i + 1}-${at}`, label: `Mass${on}`, unit: "kg", from: 0.05, to: 50, isLog: 1, of: (v) => v.robots[i].mass[at], toml: (v, m) => `robot${i + 1}.mass = ${list(withAt(v.robots[i].mass, at, m))}` },
        { id: `damping-${i + 1}-${at}`, label: `Damping${on}`, unit: "N·s/m", from: 0, to: 200, isLog: 0.1, of: (v) => v.robots[i].damping[at], toml: (v, b) => `robot${i + 1}.damping = ${list(withAt(v.robots[i].damping, at, b))}` },
      ];
    });
  const grip = (i) => {
    const ends = ["stiffness", "damping", "mass"].flatMap((key) => {
      const about = { stiffness: ["Grip stiffness", "N/m", 2000, 1], damping: ["Grip damping", "N·s/m", 50, 0.1], mass: ["Mass of the hand", "kg", 5, 0.01] }[key];
      return [0, 1].map((end) => ({
        id: `grip-${key}-${i + 1}-${end}`,
        label: `${about[0]}, ${end === 0 ? "least" : "most"}`,
        unit: about[1],
        from: 0,
        to: about[2],
        isLog: about[3],
        of: (v) => v.operators[i][key][0][end],
        toml: (v, value) => {
          const [low, high] = v.operators[i][key][0];
          const [least, most] = end === 0 ? [value, Math.max(value, high)] : [Math.min(value, low), value];
          return `operator${i + 1}.${key} = ${least === most ? most : `{min = ${least}, max = ${most}}`}`;
        },
      }));
    });
    return ends;
  };
  return [
    { title: "Spring and network", controls: coupling, isOpen: true },
    { title: values.robots[0].name ? `Robot 1: ${values.robots[0].name}` : "Robot 1", controls: robot(0), isOpen: true },
    { title: values.robots[1].name ? `Robot 2: ${values.robots[1].name}` : "Robot 2", controls: robot(1), isOpen: true },
    { title: "Hand at robot 1", controls: grip(0), note: "All 0 is a free handle. From least to most: the answer holds for every hand between them, and for a free handle." },
    { title: "Hand at robot 2", controls: grip(1) },
  ];
}

/** The controls of a study; `change` gets a TOML table of changes, `settle` is called when a value stays. */
export function createControls(host, { change, settle }) {
  let shape = null;
  let parts = [];
  let current = null;
  const buffer = html("input", { type: "checkbox", id: "playout-buffer" });
  buffer.addEventListener("change", () => {
    change(`network.playout_buffer = ${buffer.checked}`);
    settle();
  });
  const changed = (definition, value, isFinal) => {
    if (value !== null) change(definition.toml(current, value));
    if (isFinal) settle();
  };
  const build = (values) => {
    parts = [];
    const made = groups(values).map(({ title, controls, note, isOpen }, i) => {
      const own = controls.map((definition) => control(definition, changed));
      parts.push(...own);
      const extra =
        i === 0
          ? html("div", { className: "control check" }, buffer, html("label", { htmlFor: "playout-buffer" }, "Both sides wait for the latest sample (play-out buffer)"), html("p", { className: "hint" }, "It makes a delay that varies constant: delay and jitter together."))
          : null;
      return html("details", { open: isOpen ?? false, className: "group" }, html("summary", {}, html("h3", {}, title)), note ? html("p", { className: "hint" }, note) : null, ...own.map((part) => part.element), extra);
    });
    host.replaceChildren(...made);
  };
  return {
    show(values) {
      current = values;
      const now = JSON.stringify([values.axes, values.robots.map((robot) => robot.name), values.delay[0] === values.delay[1]]);
      if (now !== shape) build(values);
      shape = now;
      for (const part of parts) part.show(values);
      buffer.checked = values.playout_buffer;
    },
  };
}
