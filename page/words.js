// The answer in words.

import { digits, stiffness, time, unbounded } from "./numbers.js";

export const WORDS = { stable: "Stable", marginal: "Marginal", unstable: "Unstable", "not proven": "Not proven" };

/** What the word means, for a reader who meets it first. */
export const MEANING = {
  stable: "After any push the motion of the robots dies away. It stays so with 5 % more stiffness or delay.",
  marginal: "The motion dies away, but less than 5 % more stiffness or delay may be enough to shake it up.",
  unstable: "The robots shake each other: a small push grows into large oscillations by itself.",
  "not proven": "No rule proves that the motion dies away, and nothing shows that it must grow.",
};

/** The verdicts on kinds of networks: key of the answer, what it assumes, and in short. */
export const TIERS = [
  ["constant_delay", "one constant delay", "Every sample takes exactly your delay, as behind a play-out buffer."],
  ["any_constant_delay", "any constant delay", "The delay is constant, but nobody knows how long it is."],
  ["age_in_a_range", "a delay that varies in a range", "The delay varies as it likes between its least and its most; samples are played in order."],
  ["bounded_varying_delay", "a delay that varies up to a bound", "The delay varies as it likes, samples jump and get lost; none in use is older than the bound."],
  ["any_network", "any network", "Any delay, loss and reordering, with gaps of bounded length."],
];

const worst = ["stable", "marginal", "not proven", "unstable"];

/** The answer for held and free handles together: the worse of both. */
export function worseOf(answer) {
  const cases = [answer, answer.free].filter(Boolean);
  return cases.reduce((one, other) => (worst.indexOf(other.status) > worst.indexOf(one.status) ? other : one));
}

/** Whether what decides is the answer while the delay varies. */
export const isVarying = (answer) => answer.varying_delay !== null && !answer.playout_buffer;

/** The largest stiffness, N/m, and the longest delay, s, within which the answer holds. */
export function limits(answer) {
  const { remedies, varying_delay: varying } = answer;
  const constant = unbounded(remedies.stiffness, remedies.stiffness_unbounded) ?? 0;
  return {
    stiffness: isVarying(answer) ? unbounded(varying.stiffness_limit, varying.stiffness_unbounded) ?? 0 : constant,
    constantStiffness: constant,
    delay: unbounded(remedies.delay, remedies.delay_unbounded) ?? 0,
  };
}

/** By what margin: a sentence or two. */
export function marginSentence(answer) {
  const at = limits(answer);
  const k = answer.stiffness;
  const delay = answer.constant_delay.mean;
  if (isVarying(answer)) {
    const proven = at.stiffness === 0 ? "No stiffness is proven" : `Proven is a stiffness up to ${stiffness(at.stiffness, "down")}`;
    const buffer = answer.constant_delay.status;
    return `${proven} while the delay varies. With a play-out buffer that makes the delay constant (${time(delay)}): ${buffer}.`;
  }
  const sentences = [];
  if (k < at.stiffness && Number.isFinite(at.stiffness)) {
    sentences.push(`The stiffness may grow by ${digits((at.stiffness / k - 1) * 100, 3, "down")} %, to ${stiffness(at.stiffness, "down")}.`);
  } else if (Number.isFinite(at.stiffness) && answer.status === "unstable") {
    sentences.push(at.stiffness > 0 ? `At this delay the stiffness must be below ${stiffness(at.stiffness, "down")}.` : "At this delay no stiffness is known to be stable.");
  }
  if (!Number.isFinite(at.delay)) sentences.push("No constant delay, however long, destabilises it.");
  else if (delay < at.delay) sentences.push(`The delay may grow by ${time(at.delay - delay, "down")}, to ${time(at.delay, "down")} each way.`);
  else if (answer.status === "unstable") sentences.push(at.delay > 0 ? `At this stiffness the delay must be below ${time(at.delay, "down")} each way.` : "At this stiffness no delay is stable.");
  else sentences.push(`It is stable again beyond a first limit of ${time(at.delay, "down")}.`);
  return sentences.join(" ");
}

/** What was asked, in a sentence. */
export function questionSentence(values) {
  const [forward, backward] = values.delay;
  const [more, moreBackward] = values.jitter;
  const delay = forward === backward ? `${time(forward)} each way` : `${time(forward)} there and ${time(backward)} back`;
  const jitter = more === 0 && moreBackward === 0 ? "" : `, up to ${time(Math.max(more, moreBackward))} more`;
  const gap = values.max_gap > 0 ? `, gaps of up to ${time(values.max_gap)}` : "";
  const damping = values.coupling_damping > 0 ? ` with ${digits(values.coupling_damping)} N·s/m beside it` : "";
  const computing = values.computing_time > 0 ? `, which compute for ${time(values.computing_time)}` : "";
  const sampling = values.sample_period > 0 ? `controllers sampled every ${time(values.sample_period)}${computing}` : "continuous controllers";
  return `${stiffness(values.stiffness)}${damping} over ${delay}${jitter}${gap}, ${sampling}`;
}

/** What the page does not know of a study that it shows. */
export function notes(values) {
  const found = [];
  if (values.not_judged.length) found.push(`Nothing is proven: not judged is ${values.not_judged.join(", ")}.`);
  if (values.ages_from.length) found.push(`The ages of the samples come from ${values.ages_from.join(", ")}, beside delay and jitter.`);
  if (values.has_uncertainty) found.push("The errors of the robots' parameters are left out here: telespring decide counts them.");
  if (values.names_arms_or_agents) found.push("The arms and agents of the study are left out here: telespring decide judges them, too.");
  return found;
}
