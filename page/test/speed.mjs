// How fast the page is: `node speed.mjs [times]` in this folder, `taskset -c 0 node speed.mjs` for one core.
import { pathToFileURL } from "node:url";
import { launch, page_file } from "./browser.mjs";

const times = Number(process.argv[2] ?? 15);
const browser = await launch();

const quantile = (numbers, share) => [...numbers].sort((a, b) => a - b)[Math.min(numbers.length - 1, Math.floor(share * numbers.length))];
const tell = (what, numbers) => console.log(`${what}: median ${quantile(numbers, 0.5).toFixed(1)} ms, slowest of ${numbers.length} ${quantile(numbers, 1).toFixed(1)} ms`);

/** From the start of the navigation until the answer is in the document, and until it and the map are laid out. */
const opened = [];
const laid = [];
for (let i = 0; i < times; i++) {
  const context = await browser.newContext({ viewport: { width: 1200, height: 900 } });
  const page = await context.newPage();
  await page.addInitScript(() => {
    const until = (found, then) => {
      const check = () => (found() ? then() : requestAnimationFrame(check));
      check();
    };
    until(
      () => document.documentElement?.dataset.ready === "true",
      () => (window.answered = performance.now()),
    );
    until(
      () => document.querySelector("#map .stable-region"),
      () => requestAnimationFrame(() => (window.laid = performance.now())),
    );
  });
  await page.goto(pathToFileURL(page_file).href);
  await page.waitForFunction(() => window.answered && window.laid);
  const [answered, shown] = await page.evaluate(() => [window.answered, window.laid]);
  opened.push(answered);
  laid.push(shown);
  await context.close();
}
tell("first answer after opening", opened);
tell("first map after opening", laid);

const context = await browser.newContext({ viewport: { width: 1200, height: 900 } });
const page = await context.newPage();
await page.goto(pathToFileURL(page_file).href);
await page.waitForFunction(() => document.querySelector("#nyquist svg"));
for (const [what, changes] of [
  ["map, sampled controllers", "controller.sample_period = 0.001"],
  ["map, continuous controllers", "controller.sample_period = 0"],
]) {
  const found = await page.evaluate(
    async ([own, count]) => {
      const { page, engine } = window.telespring;
      const reads = [];
      const shows = [];
      for (let i = 0; i < count; i++) {
        const { toml } = engine.study(page.study(), `${own}\nrobot1.damping = ${5 + 0.01 * i}`);
        // the page draws in the next frame: asked before it and after it
        const frame = new Promise((resolve) => {
          let start;
          requestAnimationFrame(() => (start = performance.now()));
          page.open(toml);
          requestAnimationFrame(() => {
            document.body.getBoundingClientRect();
            resolve(performance.now() - start);
          });
        });
        shows.push(await frame);
        const { extent } = page.state();
        const start = performance.now();
        engine.map(toml, extent.stiffness, extent.delay, 500);
        reads.push(performance.now() - start);
        await new Promise((resolve) => setTimeout(resolve, 300));
      }
      return { reads, shows };
    },
    [changes, times],
  );
  tell(`${what}: computed`, found.reads);
  tell(`${what}: computed, drawn and laid out`, found.shows);
}
await browser.close();
