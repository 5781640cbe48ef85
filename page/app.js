// The page: one study, shown and changed.

import { showAnswer } from "./answer.js";
import { decideCommand, decideOptions } from "./command.js";
import { createControls } from "./controls.js";
import { createDetails } from "./details.js";
import { fromHash, toHash } from "./link.js";
import { createMessage } from "./message.js";
import { createRegion } from "./region.js";
import { addPictureButtons, wireSharing } from "./sharing.js";
import { START, judged } from "./study.js";

/** Runs the page in a document whose parts have their ids. `tell` hears of each study that stays. */
export function runPage(engine, attackAt, { first, tell, isInside }) {
  const part = (id) => document.getElementById(id);
  const state = { study: "", values: null, answer: null };
  const message = createMessage(part("message"));

  /** Takes a study with changes, if the core accepts it; the answer is shown at once. */
  const take = (study, changes = "") => {
    Object.assign(state, judged(engine, study, changes));
    showAnswer(part("answer"), state.values, state.answer);
    controls.show(state.values);
    part("command").textContent = decideCommand(state.values);
    part("command-note").hidden = decideOptions(state.values) !== null;
    message.say("");
  };
  const tried = (act) => {
    try {
      act();
      return true;
    } catch (error) {
      message.refuse(error);
      return false;
    }
  };

  let frame = null;
  /** Shows the rest in the next frame. */
  const later = () => {
    frame ??= requestAnimationFrame(() => {
      frame = null;
      tried(() => region.show(state));
      details.show(state);
    });
  };
  /** A value that is still moved: only what follows at once. */
  const change = (changes) => {
    if (tried(() => take(state.study, changes))) later();
  };
  /** A value stays: the map reaches as far as it needs, the address and whoever listens are told. */
  const settle = () => {
    region.reach(state);
    part("spoken").textContent = `${part("verdict").textContent}. ${part("margin").textContent}`;
    tell(state.study);
    try {
      history.replaceState(null, "", toHash(state.study));
    } catch {
      // inside a notebook there is no address of its own
    }
    later();
  };
  const open = (study, changes = "") => {
    if (!tried(() => take(study, changes))) return false;
    region.forget();
    settle();
    return true;
  };

  const controls = createControls(part("controls"), { change, settle });
  const region = createRegion(engine, part("map"), { change, settle });
  const details = createDetails(engine, part, region);
  addPictureButtons(part, region, message);
  wireSharing(part, message, { open, openStart: () => open("", START), study: () => state.study, isInside });

  part("attack").addEventListener("click", async () => {
    const own = { ...state };
    part("attack").disabled = true;
    message.say("Searching for an attack: a network that varies its delay to make the motion grow …");
    await region.addAttacks(own, attackAt, () => state.study === own.study);
    if (state.study === own.study) message.say("");
    part("attack").disabled = false;
  });
  addEventListener("hashchange", () => {
    const study = fromHash(location.hash);
    if (study !== null && study !== state.study) open(study);
  });
  let width = innerWidth;
  addEventListener("resize", () => {
    if (innerWidth !== width) later();
    width = innerWidth;
  });

  const given = fromHash(location.hash) ?? first;
  if (given === null || !open(given)) {
    const refusal = given === null ? null : message.text();
    open("", START);
    if (refusal) message.warn(`The study in the address was refused: ${refusal}`);
  }
  document.documentElement.dataset.ready = "true";
  return { open, study: () => state.study, state: () => ({ ...state, extent: region.extent(), attacks: region.attacks() }) };
}
