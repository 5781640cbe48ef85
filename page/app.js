// The page: one study, shown and changed.

import { showAnswer } from "./answer.js";
import { decideCommand, decideOptions } from "./command.js";
import { createControls } from "./controls.js";
import { createDetails } from "./details.js";
import { DAMAGED, fromHash, toHash } from "./link.js";
import { createMessage } from "./message.js";
import { stiffness } from "./numbers.js";
import { createRegion } from "./region.js";
import { addPictureButtons, wireSharing } from "./sharing.js";
import { START, judged } from "./study.js";

/** What is said of a link that is damaged. */
const DAMAGE = "The study in the address is damaged, perhaps since the link was cut: copy the whole link.";

/** What a search for attacks has found, in words. */
function attackWords(found, extent) {
  const least = Math.min(...found.map((attack) => attack.stiffness ?? Infinity));
  if (least === Infinity) return "No attack was found. That proves nothing: a cleverer one may exist.";
  if (least > extent.stiffness) return `Attacks were found only from ${stiffness(least)} on, beyond the map. Below it nobody knows.`;
  return "Crosses on the map mark where an attack was found.";
}

/** Runs the page in a document whose parts have their ids. `tell` hears of each study that stays. */
export function runPage(engine, attackAt, { first, tell, isInside }) {
  const part = (id) => document.getElementById(id);
  const state = { study: "", values: null, answer: null };
  const message = createMessage(part("message"));

  /** Takes a study with changes, if the core accepts it; the answer is shown at once. */
  const take = (study, changes = "", isOther = false) => {
    Object.assign(state, judged(engine, study, changes));
    if (isOther) controls.forget();
    showAnswer(part("answer"), state.values, state.answer);
    controls.show(state.values);
    part("command").textContent = decideCommand(state.values);
    part("command-note").hidden = decideOptions(state.values) !== null;
    message.say("");
  };
  /** Why it is refused, if it is. */
  const refusalOf = (act) => {
    try {
      act();
      return "";
    } catch (error) {
      message.refuse(error);
      return message.text();
    }
  };

  let frame = null;
  /** Shows the rest in the next frame. */
  const later = () => {
    frame ??= requestAnimationFrame(() => {
      frame = null;
      refusalOf(() => region.show(state));
      details.show(state);
    });
  };
  /** A value that is still moved: only what follows at once. */
  const change = (changes) => {
    const refusal = refusalOf(() => take(state.study, changes));
    if (!refusal) later();
    return refusal;
  };
  /** A value stays: the map reaches as far as it needs, the address and whoever listens are told. */
  const settle = (keep = "replaceState") => {
    region.reach(state);
    part("spoken").textContent = `${part("verdict").textContent}. ${part("margin").textContent}`;
    tell(state.study);
    try {
      const hash = toHash(state.study);
      if (hash !== location.hash) history[keep](null, "", hash);
    } catch {
      // inside a notebook there is no address of its own
    }
    later();
  };
  /** Opens another study; the browser's way back leads to the one before, unless that is where it comes from. */
  const open = (study, changes = "", keep = state.study ? "pushState" : "replaceState") => {
    if (refusalOf(() => take(study, changes, true))) return false;
    region.forget();
    settle(keep);
    if (state.assumed.length) message.say(`The study leaves open ${state.assumed.join(" and ")}.`);
    return true;
  };

  const controls = createControls(part("controls"), { change, refuse: message.warn, settle: () => settle() });
  const region = createRegion(engine, part("map"), { change, settle: () => settle() });
  const details = createDetails(engine, part, region);
  const openStart = () => {
    const before = state.study;
    open("", START);
    if (!isInside && state.study !== before) message.say("The browser's way back leads to your study again.");
  };
  addPictureButtons(part, region, message);
  wireSharing(part, message, { open, openStart, study: () => state.study, isInside });

  part("attack").addEventListener("click", async () => {
    const own = { ...state };
    part("attack").disabled = true;
    message.say("Searching for an attack: a network that varies its delay to make the motion grow …");
    const isCurrent = () => state.study === own.study;
    try {
      const found = await region.addAttacks(own, attackAt, isCurrent);
      if (isCurrent()) message.say(attackWords(found, region.extent()));
    } catch (error) {
      if (isCurrent()) message.warn(`The search failed: ${error.message}`);
    }
    part("attack").disabled = false;
    // a button that is disabled loses the focus
    if (document.activeElement === document.body) part("attack").focus({ preventScroll: true });
  });
  addEventListener("hashchange", () => {
    const study = fromHash(location.hash);
    if (study === DAMAGED) message.warn(`${DAMAGE} The study on the page stays as it was.`);
    else if (study !== null && study !== state.study) open(study, "", "replaceState");
  });
  let width = innerWidth;
  addEventListener("resize", () => {
    if (innerWidth !== width) later();
    width = innerWidth;
  });

  const given = fromHash(location.hash) ?? first;
  if (given === null || given === DAMAGED || !open(given)) {
    const refusal = given === null ? "" : given === DAMAGED ? DAMAGE : `The study in the address was refused: ${message.text()}`;
    open("", START);
    if (refusal) message.warn(`${refusal} Shown are the paper's robots.`);
  }
  document.documentElement.dataset.ready = "true";
  return { open, study: () => state.study, state: () => ({ ...state, extent: region.extent(), attacks: region.attacks() }) };
}
