// Starts the page: compiles the core that the page carries, and listens to a notebook around it.

import { runPage } from "./app.js";
import { Refused, STATE, createEngine } from "./engine.js";
import { fromHash } from "./link.js";

/** The bytes that a text in base64 stands for. */
function bytesOf(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** The core that the page carries, unpacked and compiled at once. */
async function compiledCore() {
  const packed = new Blob([bytesOf(document.getElementById("core").textContent.trim())]);
  const stream = packed.stream().pipeThrough(new DecompressionStream("gzip"));
  const response = new Response(stream, { headers: { "Content-Type": "application/wasm" } });
  return WebAssembly.compileStreaming ? WebAssembly.compileStreaming(response) : WebAssembly.compile(await response.arrayBuffer());
}

/** Asks for an attack on another thread, or on this one where a page may not have others. */
function createAttacker(engine) {
  const source = `const STATE=${STATE};${Refused};const createEngine=${createEngine};let engine=null;
    onmessage=({data})=>{if(data.module){engine=createEngine(data.module);return;}
    try{postMessage({id:data.id,found:engine.attack(data.study,data.delay,data.seed)});}catch(error){postMessage({id:data.id,error:error.message});}};`;
  const here = async (study, delay, seed) => {
    await new Promise((resume) => setTimeout(resume, 30));
    return engine.attack(study, delay, seed);
  };
  let worker;
  try {
    worker = new Worker(URL.createObjectURL(new Blob([source], { type: "text/javascript" })));
    worker.postMessage({ module: engine.module });
  } catch {
    return here;
  }
  let last = 0;
  let isBroken = false;
  return (study, delay, seed) => {
    if (isBroken) return here(study, delay, seed);
    return new Promise((resolve, reject) => {
      const id = ++last;
      const answered = ({ data }) => {
        if (data.id !== id) return;
        worker.removeEventListener("message", answered);
        if (data.found) resolve(data.found);
        else reject(new Error(data.error));
      };
      worker.addEventListener("message", answered);
      worker.addEventListener("error", () => ((isBroken = true), resolve(here(study, delay, seed))), { once: true });
      worker.postMessage({ id, study, delay, seed });
    });
  };
}

/** Opens the page once its core is compiled. */
async function startPage() {
  const engine = createEngine(await compiledCore());
  const isEmbedded = window.parent !== window;
  const embedded = document.getElementById("study");
  const page = runPage(engine, createAttacker(engine), {
    isInside: isEmbedded,
    first: embedded ? fromHash(embedded.textContent) : null,
    tell: (study) => isEmbedded && window.parent.postMessage({ telespring: "study", study }, "*"),
  });
  addEventListener("message", (event) => {
    const isFromParent = event.source === window.parent && isEmbedded;
    if (isFromParent && event.data?.telespring === "open" && event.data.study !== page.study()) page.open(event.data.study);
  });
  // for tests, and for the curious
  window.telespring = { engine, page };
}

startPage().catch((error) => {
  document.getElementById("message").textContent = `The page cannot start in this browser: ${error.message}`;
});
