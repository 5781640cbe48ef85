// What takes longer than the answer: the verdicts by kind of network, the motion, the curves, and the map's bands.

import { showVerdicts } from "./answer.js";
import { showNyquist, showRoots } from "./curves.js";
import { createMotion } from "./motion.js";
import { html } from "./svg.js";
import { isVarying, worseOf } from "./words.js";

/** Delays of the root locus. */
const ROOT_STEPS = 60;

/** The parts of the page below the answer; `part` finds an element by its id. */
export function createDetails(engine, part, region) {
  let round = 0;
  let axis = 0;
  let current = null;
  const motion = createMotion(part("motion"));

  const showCurves = ({ study, values, answer }) => {
    const delay = answer.constant_delay.mean;
    try {
      showNyquist(part("nyquist"), engine.nyquist(study, axis), values.axes[axis]);
      showRoots(part("roots"), engine.roots(study, axis, Math.max(region.extent().delay, 1.2 * delay), ROOT_STEPS), values.axes[axis], delay);
    } catch (error) {
      part("nyquist").replaceChildren();
      part("roots").replaceChildren(html("p", { className: "reading" }, error.message));
    }
  };
  const showMotion = ({ study, values, answer }) => {
    const { status } = worseOf(answer);
    const isStable = status === "unstable" ? false : status === "not proven" ? null : true;
    motion.show(engine, study, axis, values.sample_period, isStable);
  };
  const showAxes = ({ axes }) => {
    const choice = part("axis");
    choice.parentElement.hidden = axes.length < 2;
    choice.replaceChildren(...axes.map((name, i) => html("option", { value: String(i), selected: i === axis }, `axis ${name}`)));
  };
  part("axis").addEventListener("change", () => {
    axis = Number(part("axis").value);
    showMotion(current);
    showCurves(current);
  });

  return {
    /** Shows a study piece by piece, unless something changes in the meantime. */
    async show(state) {
      const own = ++round;
      const pause = () => new Promise((resume) => setTimeout(() => resume(own === round), 0));
      current = { ...state };
      axis = Math.min(axis, state.values.axes.length - 1);
      if (!(await pause())) return;
      showVerdicts(part("verdicts"), state.values, state.answer);
      showAxes(state.values);
      showMotion(current);
      if (!(await pause())) return;
      showCurves(current);
      part("attack").hidden = !isVarying(worseOf(state.answer));
      await region.addBands(current, pause);
    },
  };
}
