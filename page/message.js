// What the page says in a line: what was done, and what was refused.

import { Refused } from "./engine.js";
import { html } from "./svg.js";

/** The page's line of text in an element. */
export function createMessage(element) {
  const say = (text, ...more) => {
    element.classList.remove("refusal");
    element.replaceChildren(text, ...more);
  };
  return {
    say,
    /** Says something with a button beside it. */
    offer(text, label, act) {
      const button = html("button", { type: "button" }, label);
      button.addEventListener("click", act);
      say(`${text} `, button);
    },
    /** Says that something was refused. */
    warn(text) {
      say(text);
      element.classList.add("refusal");
    },
    /** Says what the core refuses, in its words; any other error is the page's own. */
    refuse(error) {
      if (!(error instanceof Refused || error instanceof WebAssembly.RuntimeError)) throw error;
      this.warn(error instanceof Refused ? error.message : "The computation failed; the study is left as it was.");
    },
    text: () => element.textContent,
  };
}
