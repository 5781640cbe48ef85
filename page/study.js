// A study with the values and the answer that the core makes of it.

import { stiffness, time } from "./numbers.js";

/** The stiffness, N/m, and the delay each way, s, at which the paper's robots are stable. */
const SHOWN = { stiffness: 71.2, delay: 0.1 };
/** What a study must have that a page shows, and what is said where it leaves it open. */
const OPEN = {
  stiffness: { changes: `coupling.stiffness = ${SHOWN.stiffness}`, words: `the stiffness (shown is ${stiffness(SHOWN.stiffness)})` },
  delay: { changes: `network.delay = ${SHOWN.delay}`, words: `the delay (shown is ${time(SHOWN.delay)} each way)` },
};
/** The paper's robots at a condition that is stable. */
export const START = `${OPEN.stiffness.changes}\n${OPEN.delay.changes}\n`;

/** A study with changes, {study, values, answer, assumed}, where `assumed` says what it left open; throws what the core refuses. */
export function judged(engine, study, changes) {
  let values = engine.study(study, changes);
  const missing = Object.keys(OPEN).filter((key) => values[key] === null).map((key) => OPEN[key]);
  if (missing.length) values = engine.study(values.toml, missing.map((each) => each.changes).join("\n"));
  return { study: values.toml, values, answer: engine.decide(values.toml), assumed: missing.map((each) => each.words) };
}

/** The mean of the delays of both ways, s. */
export const meanDelay = (values) => (values.delay[0] + values.delay[1]) / 2;

/** The changes that put a study at a stiffness, N/m, and a mean delay, s, in the proportion of its ways. */
export function movedTo(values, stiffness, delay, round) {
  const mean = meanDelay(values);
  const [forward, backward] = values.delay.map((way) => round(mean > 0 ? (way / mean) * delay : delay));
  const delays = forward === backward ? String(forward) : `{forward = ${forward}, backward = ${backward}}`;
  return `coupling.stiffness = ${round(stiffness)}\nnetwork.delay = ${delays}`;
}
