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

/** A limit of each kind: N/m at the constant delay, s at the stiffness, N/m while the delay varies. */
const constantLimit = ({ remedies }) => unbounded(remedies.stiffness, remedies.stiffness_unbounded) ?? 0;
const delayLimit = ({ remedies }) => unbounded(remedies.delay, remedies.delay_unbounded) ?? 0;
const varyingLimit = ({ varying_delay: varying }) => unbounded(varying.stiffness_limit, varying.stiffness_unbounded) ?? 0;

/** The answer for held and free handles together: the worse word of both, and of each limit the lower one. */
export function worseOf(answer) {
  if (!answer.free) return answer;
  const { free } = answer;
  const worse = (word) => (worst.indexOf(word(free)) > worst.indexOf(word(answer)) ? free : answer);
  const lower = (limit) => (limit(free) < limit(answer) ? free : answer);
  const { stiffness, stiffness_unbounded } = lower(constantLimit).remedies;
  return {
    ...worse((each) => each.status),
    constant_delay: worse((each) => each.constant_delay.status).constant_delay,
    varying_delay: answer.varying_delay && lower(varyingLimit).varying_delay,
    remedies: { ...lower(delayLimit).remedies, stiffness, stiffness_unbounded },
  };
}

/** Whether what decides is the answer while the delay varies. */
export const isVarying = (answer) => answer.varying_delay !== null && !answer.playout_buffer;

/** The largest stiffness, N/m, and the longest delay, s, within which the answer holds. */
export function limits(answer) {
  const constantStiffness = constantLimit(answer);
  return { stiffness: isVarying(answer) ? varyingLimit(answer) : constantStiffness, constantStiffness, delay: delayLimit(answer) };
}

const areSame = ({ forward, backward }) => forward === backward;

/** What the delay of an answer is called. */
export function delayName({ constant_delay: delay }) {
  const name = areSame(delay) ? "delay" : "mean delay of both ways";
  return delay.buffered ? `${name} behind the buffer` : name;
}

/** By what margin: a sentence or two. */
export function marginSentence(values, answer) {
  if (values.not_judged.length) return "No margin is proven.";
  if (isVarying(answer)) return varyingSentence(answer);
  const sentences = [stiffnessSentence(answer), delaySentence(answer)].filter(Boolean);
  return sentences.length ? sentences.join(" ") : "No margin is proven.";
}

function varyingSentence(answer) {
  const { stiffness: limit } = limits(answer);
  const proven = limit === 0 ? "No stiffness is proven" : Number.isFinite(limit) ? `Proven is a stiffness up to ${stiffness(limit, "down")}` : "Every stiffness is proven";
  const { mean, status } = answer.constant_delay;
  return `${proven} while the delay varies. With a play-out buffer that makes the delay constant (${time(mean)}): ${status}.`;
}

function stiffnessSentence(answer) {
  const { stiffness: limit } = limits(answer);
  const isUnstable = answer.status === "unstable";
  if (limit === Infinity) return isUnstable ? "" : "No stiffness, however large, destabilises it at this delay.";
  if (answer.stiffness < limit && !isUnstable) return `The stiffness may grow by ${digits((limit / answer.stiffness - 1) * 100, 3, "down")} %, to ${stiffness(limit, "down")}.`;
  if (!isUnstable) return "";
  return limit > 0 ? `At this delay the stiffness must be below ${stiffness(limit, "down")}.` : "At this delay no stiffness is known to be stable.";
}

function delaySentence(answer) {
  const { delay: limit } = limits(answer);
  const { mean } = answer.constant_delay;
  const { delay_attained: isAttained } = answer.remedies;
  const name = delayName(answer);
  const each = areSame(answer.constant_delay) ? " each way" : "";
  if (limit === Infinity) return "No constant delay, however long, destabilises it.";
  if (answer.status === "unstable") {
    if (limit === 0) return "At this stiffness no delay above 0 is stable.";
    return `At this stiffness the ${name} must be ${isAttained ? "at most" : "below"} ${time(limit, "down")}${each}.`;
  }
  // both are known to far less than a picosecond
  const more = Number((limit - mean).toFixed(12));
  if (more > 0) return `The ${name} may grow by ${time(more, "down")}, to ${time(limit, "down")}${each}.`;
  if (more === 0 && isAttained) return `The ${name} may not grow: it is the last whole number of sample periods.`;
  return answer.status === "not proven" ? "" : `It is stable again beyond a first limit of ${time(limit, "down")}.`;
}

/** What was asked, in a sentence. */
export function questionSentence(values) {
  const [forward, backward] = values.delay;
  const [more, moreBackward] = values.jitter;
  const delay = forward === backward ? `${time(forward)} each way` : `${time(forward)} there and ${time(backward)} back`;
  const jitter = more === 0 && moreBackward === 0 ? "" : `, up to ${time(Math.max(more, moreBackward))} more`;
  const gap = values.max_gap > 0 ? `, gaps of up to ${time(values.max_gap)}` : "";
  const buffer = values.playout_buffer && (jitter || gap) ? ", behind a play-out buffer" : "";
  const damping = values.coupling_damping > 0 ? ` with ${digits(values.coupling_damping)} N·s/m beside it` : "";
  const computing = values.computing_time > 0 ? `, which compute for ${time(values.computing_time)}` : "";
  const sampling = values.sample_period > 0 ? `controllers sampled every ${time(values.sample_period)}${computing}` : "continuous controllers";
  return `${stiffness(values.stiffness)}${damping} over ${delay}${jitter}${gap}${buffer}, ${sampling}${heldClause(values)}`;
}

/** Which robots a hand may hold. */
function heldClause({ operators }) {
  const held = operators.flatMap((hand, i) => (Object.values(hand).flat(2).some((value) => value > 0) ? [i + 1] : []));
  return held.length === 0 ? "" : held.length === 2 ? "; both robots held, or free" : `; robot ${held[0]} held, or free`;
}

/** What the rules do not cover, in words. */
const NOT_JUDGED = {
  "unread trace": "the recorded trace, which is not on this page",
  "lying peer": "a peer that may lie",
  predictor: "the predictor",
  strategy: "the strategy of the session",
  "actuator lag": "the lag of the actuators",
};

/** What the page does not know of a study that it shows. */
export function notes(values) {
  const found = [];
  const holds = (end) => (hand) => Object.values(hand).some((ends) => ends.some((pair) => pair[end] > 0));
  if (values.operators.every(holds(1)) && values.operators.some(holds(0))) found.push("One hand that lets go while the other holds is judged only where the least of both hands is 0.");
  if (values.not_judged.length) found.push(`Nothing is proven, since this is not judged: ${values.not_judged.map((each) => NOT_JUDGED[each] ?? each).join(", ")}.`);
  if (values.ages_from.length) found.push(`The ages of the samples come from ${values.ages_from.join(", ")}, beside delay and jitter.`);
  if (values.has_uncertainty) found.push("The errors of the robots' parameters are left out here: telespring decide counts them.");
  if (values.names_arms_or_agents) found.push("The arms and agents of the study are left out here: telespring decide judges them, too.");
  return found;
}
