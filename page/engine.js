// The core of telespring as WebAssembly: text and numbers in, answers out.

/** The core refused a value: field, allowed values and remedy are in `refusal`. */
export class Refused extends Error {
  constructor(refusal) {
    super(refusal.refused);
    this.refusal = refusal;
  }
}

/** Numbers per state of the live robots: docs of `Live::STATE`. */
export const STATE = 13;

/** Makes an engine of a compiled module. */
export function createEngine(module) {
  let core = new WebAssembly.Instance(module, {}).exports;
  const encoder = new TextEncoder();
  const decoder = new TextDecoder();

  const write = (...texts) => {
    const parts = texts.map((text) => encoder.encode(text));
    const length = parts.reduce((sum, part) => sum + part.length, 0);
    let at = core.telespring_input(length);
    for (const part of parts) {
      new Uint8Array(core.memory.buffer, at, part.length).set(part);
      at += part.length;
    }
    return parts[0].length;
  };
  const output = () => new Uint8Array(core.memory.buffer, core.telespring_output(), core.telespring_length());
  const answer = (refused) => {
    const value = JSON.parse(decoder.decode(output()));
    if (refused) throw new Refused(value);
    return value;
  };
  // An instance that has trapped is in no known state.
  const guarded = (call) => {
    try {
      return call();
    } catch (error) {
      if (error instanceof WebAssembly.RuntimeError) core = new WebAssembly.Instance(module, {}).exports;
      throw error;
    }
  };
  const asked = (study, call) =>
    guarded(() => {
      write(study);
      return answer(call());
    });

  return {
    module,
    study: (study, changes = "") => guarded(() => answer(core.telespring_study(write(study, changes)))),
    decide: (study) => asked(study, () => core.telespring_decide()),
    attack: (study, delay, seed) => asked(study, () => core.telespring_attack(delay, seed)),
    map: (study, stiffness, delay, columns) => asked(study, () => core.telespring_map(stiffness, delay, columns)),
    bounds: (study, delay) => asked(study, () => core.telespring_bounds(delay)),
    nyquist: (study, axis) => asked(study, () => core.telespring_nyquist(axis)),
    roots: (study, axis, longest, steps) => asked(study, () => core.telespring_roots(axis, longest, steps)),
    start: (study, axis, seed) => asked(study, () => core.telespring_start(axis, seed)),
    /** Moves the live robots; the states after each period, STATE numbers each. */
    step: (ticks, place, grip) =>
      guarded(() => {
        if (core.telespring_step(ticks, place, grip)) return new Float64Array(0);
        const bytes = output().slice();
        return new Float64Array(bytes.buffer, 0, bytes.length / 8);
      }),
  };
}
