// What the map shows of the page's study: how far it reaches, what is stable on it, and what an attack finds there.

import { bandDelays, createMap, mapExtent, readMap } from "./map.js";
import { clean } from "./numbers.js";
import { meanDelay, movedTo } from "./study.js";
import { isVarying, worseOf } from "./words.js";

/** The starts of an attack, the same each time. */
const SEED = 1;
/** The delays at which an attack is searched, of the longest on the map. */
const ATTACKED = [0.15, 0.3, 0.5, 0.75];
/** For so long, ms, the page may compute before it looks at what the reader does. */
const PATIENCE = 12;

const rounded = (value) => clean(Number(value.toPrecision(3)));

/** What the map depends on: not where the study's point is. */
function keyOf({ values, extent }) {
  const { stiffness, toml, name, delay, ...rest } = values;
  return JSON.stringify([rest, extent, delay[0] + delay[1] > 0 ? delay[0] / (delay[0] + delay[1]) : 0.5]);
}

const areRanges = ({ operators }) => operators.some((hand) => Object.values(hand).some((ends) => ends.some(([low, high]) => low !== high)));

/** The map of the page's study in an element; `change` gets a table of changes where the reader moves the point. */
export function createRegion(engine, element, { change, settle }) {
  const shown = { extent: null, key: "", found: null, bands: [], attacks: [] };
  let current = null;
  const map = createMap(element, { move: (stiffness, delay) => change(movedTo(current.values, stiffness, delay, rounded)), settle });
  const draw = () => map.show(current.values, current.answer, shown.found, shown.extent, shown.bands, shown.attacks);

  return {
    /** Shows a study; reads the map anew where it depends on what has changed. */
    show(state) {
      current = state;
      shown.extent ??= mapExtent(state.values, state.answer);
      const key = keyOf({ values: state.values, extent: shown.extent });
      if (key !== shown.key) {
        Object.assign(shown, { found: readMap(engine, state.study, shown.extent, areRanges(state.values)), key, bands: [], attacks: [] });
      }
      draw();
    },
    /** Makes the map reach as far as the study needs. */
    reach({ values, answer }) {
      const { extent } = shown;
      const ideal = mapExtent(values, answer);
      const isBeyond = !extent || values.stiffness > 0.9 * extent.stiffness || meanDelay(values) > 0.9 * extent.delay;
      const isOff = (key) => ideal[key] < 0.5 * extent[key] || ideal[key] > 1.6 * extent[key];
      if (isBeyond || isOff("stiffness") || isOff("delay")) shown.extent = ideal;
    },
    /** Another study: nothing of the map stays. */
    forget() {
      Object.assign(shown, { extent: null, key: "" });
    },
    /** Adds what is proven while the delay varies; `pause` resolves to whether it is still wanted. */
    async addBands(state, pause) {
      if (!shown.found || shown.bands.length || !isVarying(worseOf(state.answer))) return;
      const bands = [];
      let since = performance.now();
      for (const delay of bandDelays(shown.extent)) {
        bands.push(engine.bounds(state.study, delay));
        if (performance.now() - since > PATIENCE) {
          if (!(await pause())) return;
          since = performance.now();
        }
      }
      shown.bands = bands;
      draw();
    },
    /** Adds where an attack on the network is found, delay by delay, until the study is another one; returns what was found. */
    async addAttacks(state, attackAt, isCurrent) {
      const found = [];
      for (const share of ATTACKED) {
        found.push(await attackAt(state.study, share * shown.extent.delay, SEED));
        if (!isCurrent()) break;
        shown.attacks = [...found];
        draw();
      }
      return found;
    },
    extent: () => shown.extent,
    attacks: () => shown.attacks,
    drawing: () => map.drawing(),
  };
}
