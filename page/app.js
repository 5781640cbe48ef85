// The page: one study, shown and changed.

import { showAnswer, showVerdicts } from "./answer.js";
import { decideCommand, decideOptions } from "./command.js";
import { createControls } from "./controls.js";
import { showNyquist, showRoots } from "./curves.js";
import { Refused } from "./engine.js";
import { fromHash, toHash } from "./link.js";
import { bandDelays, createMap, mapExtent, readMap } from "./map.js";
import { createMotion } from "./motion.js";
import { clean } from "./numbers.js";
import { html, standalone } from "./svg.js";
import { isVarying, worseOf } from "./words.js";

/** The paper's robots at a condition that is stable. */
const START = "coupling.stiffness = 71.2\nnetwork.delay = 0.1\n";
/** What a study must have that a page shows; a file may leave it open. */
const OPEN = { stiffness: "coupling.stiffness = 71.2", delay: "network.delay = 0.1" };
const SEED = 1;

/** Runs the page in a document whose parts have their ids. `tell` hears of each study that stays. */
export function runPage(engine, attackAt, { first, tell, isInside }) {
  const part = (id) => document.getElementById(id);
  const state = { study: "", values: null, answer: null, extent: null, map: null, mapKey: "", bands: [], attacks: [], axis: 0 };
  let round = 0;

  const say = (text) => (part("message").textContent = text);
  const refuse = (error) => {
    if (!(error instanceof Refused || error instanceof WebAssembly.RuntimeError)) throw error;
    say(error instanceof Refused ? error.message : "The computation failed; the study is left as it was.");
    part("message").classList.add("refusal");
  };
  const accept = () => {
    part("message").classList.remove("refusal");
    say("");
  };

  /** Takes a study with changes, if the core accepts it; the answer is shown at once. */
  const take = (study, changes = "") => {
    let values = engine.study(study, changes);
    const missing = ["stiffness", "delay"].filter((key) => values[key] === null).map((key) => OPEN[key]);
    if (missing.length) values = engine.study(values.toml, missing.join("\n"));
    const answer = engine.decide(values.toml);
    Object.assign(state, { study: values.toml, values, answer });
    showAnswer(part("answer"), values, answer);
    controls.show(values);
    part("command").textContent = decideCommand(values);
    part("command-note").hidden = decideOptions(values) !== null;
    state.axis = Math.min(state.axis, values.axes.length - 1);
  };

  const mapKeyOf = ({ values, extent }) => {
    const { stiffness, toml, name, delay, ...rest } = values;
    return JSON.stringify([rest, extent, delay[0] + delay[1] > 0 ? delay[0] / (delay[0] + delay[1]) : 0.5]);
  };
  const showMap = () => {
    const key = mapKeyOf(state);
    if (key !== state.mapKey) {
      const isSlow = state.values.operators.some((hand) => Object.values(hand).some((ends) => ends.some(([low, high]) => low !== high)));
      Object.assign(state, { map: readMap(engine, state.study, state.extent, isSlow), mapKey: key, bands: [], attacks: [] });
    }
    map.show(state.values, state.answer, state.map, state.extent, state.bands, state.attacks);
  };

  /** Shows what takes longer, piece by piece, unless something changes in the meantime. */
  const details = async () => {
    const own = ++round;
    const { study, values, answer } = state;
    const pause = () => new Promise((resume) => setTimeout(resume, 0));
    const isOld = () => own !== round;
    await pause();
    if (isOld()) return;
    showVerdicts(part("verdicts"), values, answer);
    showAxes(values);
    motion.show(engine, study, state.axis, values.sample_period);
    await pause();
    if (isOld()) return;
    curves();
    part("attack").hidden = !isVarying(worseOf(answer));
    if (!isVarying(worseOf(answer)) || state.bands.length) return;
    const bands = [];
    let since = performance.now();
    for (const delay of bandDelays(state.extent)) {
      bands.push(engine.bounds(study, delay));
      if (performance.now() - since > 12) {
        await pause();
        if (isOld()) return;
        since = performance.now();
      }
    }
    state.bands = bands;
    showMap();
  };
  const curves = () => {
    const { study, values, answer, extent } = state;
    const axis = values.axes[state.axis];
    try {
      showNyquist(part("nyquist"), engine.nyquist(study, state.axis), axis);
      const delay = answer.constant_delay.mean;
      showRoots(part("roots"), engine.roots(study, state.axis, Math.max(extent.delay, 1.2 * delay), 60), axis, delay);
    } catch (error) {
      part("nyquist").replaceChildren();
      part("roots").replaceChildren(html("p", { className: "reading" }, error.message));
    }
  };
  const showAxes = (values) => {
    const choice = part("axis");
    choice.parentElement.hidden = values.axes.length < 2;
    choice.replaceChildren(...values.axes.map((name, i) => html("option", { value: String(i), selected: i === state.axis }, `axis ${name}`)));
  };

  let frame = null;
  const later = () => {
    frame ??= requestAnimationFrame(() => {
      frame = null;
      try {
        state.extent ??= mapExtent(state.values, state.answer);
        showMap();
      } catch (error) {
        refuse(error);
      }
      details();
    });
  };
  const settle = () => {
    const delay = (state.values.delay[0] + state.values.delay[1]) / 2;
    const ideal = mapExtent(state.values, state.answer);
    const { extent } = state;
    const isFar = !extent || state.values.stiffness > 0.9 * extent.stiffness || delay > 0.9 * extent.delay || ideal.stiffness < 0.5 * extent.stiffness || ideal.delay < 0.5 * extent.delay || ideal.stiffness > 1.6 * extent.stiffness || ideal.delay > 1.6 * extent.delay;
    if (isFar) state.extent = ideal;
    part("spoken").textContent = `${part("verdict").textContent}. ${part("margin").textContent}`;
    remember();
    later();
  };
  const remember = () => {
    tell(state.study);
    try {
      history.replaceState(null, "", toHash(state.study));
    } catch {
      // inside a notebook there is no address of its own
    }
  };
  const change = (changes) => {
    try {
      take(state.study, changes);
      accept();
      later();
    } catch (error) {
      refuse(error);
    }
  };
  const open = (study, changes = "") => {
    try {
      take(study, changes);
      state.extent = null;
      state.mapKey = "";
      accept();
      settle();
      return true;
    } catch (error) {
      refuse(error);
      return false;
    }
  };

  const controls = createControls(part("controls"), { change, settle });
  const map = createMap(part("map"), {
    move: (stiffness, delay) => {
      const { values } = state;
      const mean = (values.delay[0] + values.delay[1]) / 2;
      const round3 = (value) => clean(Number(value.toPrecision(3)));
      const ways = values.delay.map((way) => round3(mean > 0 ? (way / mean) * delay : delay));
      const delays = ways[0] === ways[1] ? String(ways[0]) : `{forward = ${ways[0]}, backward = ${ways[1]}}`;
      change(`coupling.stiffness = ${round3(stiffness)}\nnetwork.delay = ${delays}`);
    },
    settle,
  });
  const motion = createMotion(part("motion"));

  part("axis").addEventListener("change", () => {
    state.axis = Number(part("axis").value);
    motion.show(engine, state.study, state.axis, state.values.sample_period);
    curves();
  });
  part("attack").addEventListener("click", async () => {
    const button = part("attack");
    button.disabled = true;
    const { study, extent } = state;
    const found = [];
    for (const share of [0.15, 0.3, 0.5, 0.75]) {
      say("Searching for an attack: a network that varies its delay to make the motion grow …");
      found.push(await attackAt(study, share * extent.delay, SEED));
      if (state.study !== study) break;
      state.attacks = [...found];
      showMap();
    }
    say("");
    button.disabled = false;
  });

  part("open").addEventListener("click", () => part("file").click());
  part("file").addEventListener("change", async () => {
    const [file] = part("file").files;
    if (file && open(await file.text())) say(`Opened ${file.name}.`);
    part("file").value = "";
  });
  part("save").addEventListener("click", () => download("study.toml", "application/toml", state.study));
  part("paper").addEventListener("click", () => open("", START));
  // a page inside another has no address of its own
  part("link").hidden = isInside;
  part("link").addEventListener("click", () => copy(location.href.split("#")[0] + toHash(state.study), "The link"));
  part("copy-command").addEventListener("click", () => copy(part("command").textContent, "The command"));
  part("picture").addEventListener("click", () => {
    const background = getComputedStyle(document.body).getPropertyValue("--card").trim() || "white";
    download("stability-map.svg", "image/svg+xml", standalone(map.drawing(), background));
  });
  const copy = async (text, what) => {
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      const area = html("textarea", { value: text });
      document.body.append(area);
      area.select();
      document.execCommand("copy");
      area.remove();
    }
    say(`${what} is copied.`);
  };
  const download = (name, type, text) => {
    const link = html("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    say(`${name} is saved.`);
  };
  addEventListener("hashchange", () => {
    const study = fromHash(location.hash);
    if (study !== null && study !== state.study) open(study);
  });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", async (event) => {
    event.preventDefault();
    const file = event.dataTransfer?.files[0];
    if (file) open(await file.text());
  });
  let width = innerWidth;
  addEventListener("resize", () => {
    if (innerWidth !== width) later();
    width = innerWidth;
  });

  const given = fromHash(location.hash) ?? first;
  if (given === null || !open(given)) {
    const refusal = given === null ? null : part("message").textContent;
    open("", START);
    if (refusal) {
      say(`The study in the address was refused: ${refusal}`);
      part("message").classList.add("refusal");
    }
  }
  document.documentElement.dataset.ready = "true";
  return { open, study: () => state.study, state: () => state };
}
