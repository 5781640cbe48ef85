// The controls: each value by a slider and by a number with its unit.

import { clean, digits, written } from "./numbers.js";
import { areGripsAlike, areWaysAlike, gripsAlike, groups, waysAlike } from "./quantities.js";
import { html } from "./svg.js";

const STEPS = 1000;

/** A slider's way from places to values: straight, or by decades with 0 at its start. */
function scaleOf({ from, isLog }, to) {
  if (!isLog) return { value: (place) => from + (to - from) * place, place: (value) => (to > from ? (value - from) / (to - from) : 0) };
  const hasZero = from === 0;
  const least = hasZero ? isLog : from;
  const start = hasZero ? 1 / STEPS : 0;
  const span = Math.log(to / least);
  return {
    value: (place) => (hasZero && place <= 0 ? 0 : least * Math.exp((span * Math.max(place - start, 0)) / (1 - start))),
    place: (value) => (value <= 0 ? 0 : start + (1 - start) * (Math.log(Math.max(value, least) / least) / span)),
  };
}

/**
 * One value: `of` reads it from the study's values, `toml` writes it as a table of changes; shown is the value times
 * `factor`. Where the slider ends may depend on the values; where it ends at its start, the value cannot be changed.
 *
 * While the reader writes or slides, each change is one of the values from before: what else has to give way for a number
 * that is half written comes back. `change` returns why a value is refused, if it is; what is refused when the reader is done
 * leaves the study as it was.
 */
function control(definition, { change, refuse, settle }) {
  const { id, label, unit, factor = 1, hint } = definition;
  const endOf = (values) => (typeof definition.to === "function" ? definition.to(values) : definition.to);
  let scale = null;
  let current = null;
  let before = null;
  let refusal = "";
  const number = html("input", { type: "text", id, inputMode: "decimal", autocomplete: "off", spellcheck: false });
  const slider = html("input", { type: "range", min: "0", max: String(STEPS), step: "1", "aria-label": `${label}, slider` });
  const why = html("p", { className: "why", id: `${id}-why`, hidden: true });
  const hintId = `${id}-hint`;
  number.setAttribute("aria-describedby", hint ? `${why.id} ${hintId}` : why.id);
  const write = () => (number.value = String(clean(definition.of(current) * factor)));
  // rounded, it may be where it came from: set while the reader presses a key, no key would move it
  const place = () => (slider.value = String(Math.round(scale.place(definition.of(current)) * STEPS)));
  const tell = (text, isWrong) => {
    why.textContent = text;
    why.hidden = text === "";
    if (isWrong) number.setAttribute("aria-invalid", "true");
    else number.removeAttribute("aria-invalid");
  };
  const show = (values) => {
    current = values;
    const end = endOf(values);
    scale = scaleOf(definition, end);
    number.disabled = slider.disabled = end === definition.from;
    // what the reader is about to write or to slide stays
    if (before === null) {
      write();
      place();
    }
    slider.setAttribute("aria-valuetext", `${digits(definition.of(values) * factor)} ${unit}`);
    tell("", false);
  };
  const put = (value) => {
    before ??= current;
    refusal = change(definition.toml(before, value));
    tell(refusal, refusal !== "");
  };
  const back = () => change(definition.toml(before, definition.of(before)));
  const done = ({ target }) => {
    if (before === null || !number.isConnected) return;
    const text = refusal;
    if (text) back();
    before = null;
    refusal = "";
    write();
    if (text || target !== slider) place();
    if (text) {
      refuse(text);
      tell(text, false);
    }
    settle();
  };
  slider.addEventListener("input", () => {
    const value = Number(digits(scale.value(Number(slider.value) / STEPS) * factor, 3));
    number.value = String(value);
    put(clean(value / factor));
    slider.setAttribute("aria-valuetext", `${value} ${unit}`);
  });
  slider.addEventListener("change", done);
  number.addEventListener("input", () => {
    const value = written(number.value, unit);
    if (Number.isFinite(value)) return put(clean(value / factor));
    before ??= current;
    refusal = `${label}: "${number.value}" is no number in ${unit}. Write it as 1.5 or 1,5, without a separator of thousands.`;
    number.setAttribute("aria-invalid", "true");
  });
  number.addEventListener("change", done);
  number.addEventListener("blur", done);
  number.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || before === null) return;
    back();
    refusal = "";
    done(event);
  });
  const element = html(
    "div",
    { className: "control" },
    html("label", { htmlFor: id }, label),
    html("span", { className: "value" }, number, html("span", { className: "unit" }, unit)),
    slider,
    why,
    hint ? html("p", { className: "hint", id: hintId }, hint) : null,
  );
  const forget = () => {
    before = null;
    refusal = "";
  };
  return { element, show, forget };
}

/** A yes or no, with `flip` called with the new one. */
function check(id, label, hint, flip) {
  const box = html("input", { type: "checkbox", id });
  box.addEventListener("change", () => flip(box.checked));
  const element = html("div", { className: "control check" }, box, html("label", { htmlFor: id }, label), html("p", { className: "hint" }, hint));
  return { element, box };
}

/**
 * The controls of a study; `change` gets a TOML table of changes and returns why it is refused, `refuse` says such a reason again,
 * `settle` is called when a value stays.
 */
export function createControls(host, { change, refuse, settle }) {
  let shape = null;
  let parts = [];
  let current = null;
  /** What the reader wants to set apart, though it is alike. */
  const wanted = { hasOwnWays: false, hasOwnGrips: false };
  const choicesOf = (values) => ({
    hasOwnWays: wanted.hasOwnWays || !areWaysAlike(values),
    hasOwnGrips: wanted.hasOwnGrips || !areGripsAlike(values),
  });
  const write = (changes) => {
    change(changes);
    // a box that was refused shows what holds
    show(current);
    settle();
  };
  /** Sets values apart, or makes them alike again. */
  const apart = (choice, areAlike, alike) => (isApart) => {
    wanted[choice] = isApart;
    if (!isApart && !areAlike(current)) write(alike(current));
    show(current);
  };
  const buffer = check("playout-buffer", "Both sides wait for the latest sample (play-out buffer)", "It makes a delay that varies constant: delay and jitter together.", (is) => write(`network.playout_buffer = ${is}`));
  const ownWays = check("own-ways", "Each way has its own delay and jitter", "Not checked, both ways have those from robot 1 to 2.", apart("hasOwnWays", areWaysAlike, waysAlike));
  const ownGrips = check("own-grips", "Each axis is held in its own way", "Not checked, all axes are held as the first.", apart("hasOwnGrips", areGripsAlike, gripsAlike));
  const unusual = check("allow-unusual", "Allow values that no laboratory has", "Otherwise they are refused, because their unit is probably wrong.", (is) => write(`allow_unusual = ${is}`));
  const checksOf = (key, values) => ({ network: [buffer], rarer: [ownWays, unusual], hand1: values.axes.length > 1 ? [ownGrips] : [] })[key] ?? [];
  const build = (values, choices) => {
    const focused = host.contains(document.activeElement) ? document.activeElement.id : "";
    const wasOpen = new Map([...host.children].map((group) => [group.dataset.key, group.open]));
    parts = [];
    const made = groups(values, choices).map(({ key, title, controls, note, isOpen }) => {
      const own = controls.map((definition) => control(definition, { change, refuse, settle }));
      parts.push(...own);
      const group = html("details", { open: wasOpen.get(key) ?? isOpen ?? false, className: "group" }, html("summary", {}, html("h3", {}, title)), note ? html("p", { className: "hint" }, note) : null, ...own.map((part) => part.element), ...checksOf(key, values).map((each) => each.element));
      group.dataset.key = key;
      // both robots have a mass: which one it is, a screen reader says by the group
      group.setAttribute("aria-label", title);
      return group;
    });
    host.replaceChildren(...made);
    if (focused) document.getElementById(focused)?.focus();
  };
  const show = (values) => {
    current = values;
    const choices = choicesOf(values);
    const now = JSON.stringify([values.axes, values.robots.map((robot) => robot.name), choices]);
    if (now !== shape) build(values, choices);
    shape = now;
    for (const part of parts) part.show(values);
    buffer.box.checked = values.playout_buffer;
    ownWays.box.checked = choices.hasOwnWays;
    ownGrips.box.checked = choices.hasOwnGrips;
    unusual.box.checked = values.allow_unusual;
  };
  return {
    show,
    /** Another study is opened: what is half written belongs to the one before. */
    forget: () => parts.forEach((part) => part.forget()),
  };
}
