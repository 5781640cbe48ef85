// Answers calls of the page's engine: a JSON list on standard input, the answers on standard output.
import { readFileSync, writeSync } from "node:fs";

const [wasm, engineFile] = process.argv.slice(2);
const source = readFileSync(engineFile, "utf8");
const { createEngine, Refused, STATE } = await import(`data:text/javascript,${encodeURIComponent(source)}`);
const engine = createEngine(new WebAssembly.Module(readFileSync(wasm)));

const move = (study, axis, pulled, place, grip, rest) => {
  engine.start(study, axis, 1);
  const states = [];
  for (const [ticks, own] of [[pulled, grip], [rest, 0]]) {
    const found = engine.step(ticks, place, own);
    for (let i = 0; i < found.length; i += STATE) states.push(Array.from(found.subarray(i, i + STATE)));
  }
  return states;
};

const answers = JSON.parse(readFileSync(0, "utf8")).map(([name, ...parts]) => {
  try {
    return name === "move" ? move(...parts) : engine[name](...parts);
  } catch (error) {
    if (error instanceof Refused) return error.refusal;
    throw error;
  }
});
const bytes = Buffer.from(JSON.stringify(answers));
for (let at = 0; at < bytes.length; ) at += writeSync(1, bytes, at);
