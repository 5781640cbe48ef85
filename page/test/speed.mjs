// How fast the page is: `taskset -c 0 node speed.mjs [times]` in this folder, for one core.
//
// Beside the time on the clock stands the time that the page's process computed, on all of its threads: on a machine that
// others use, too, only that says something.
import { pathToFileURL } from "node:url";
import { launch, page_file } from "./browser.mjs";

const times = Number(process.argv[2] ?? 9);
const browser = await launch();

const median = (numbers) => [...numbers].sort((a, b) => a - b)[Math.floor(numbers.length / 2)];
const tell = (what, found) => {
  const of = (key) => median(found.map((each) => each[key])).toFixed(0);
  console.log(`${what}: ${of("clock")} ms, computed for ${of("computed")} ms (medians of ${found.length}; least ${Math.min(...found.map((each) => each.clock)).toFixed(0)} ms)`);
};

/** A page whose frames and pauses are held back until they are let go: what it does first is measured alone. */
async function open_held() {
  const context = await browser.newContext({ viewport: { width: 1200, height: 900 } });
  const page = await context.newPage();
  const session = await context.newCDPSession(page);
  await session.send("Performance.setTimeDomain", { timeDomain: "threadTicks" });
  await session.send("Performance.enable");
  const metrics = async () => Object.fromEntries((await session.send("Performance.getMetrics")).metrics.map(({ name, value }) => [name, 1e3 * value]));
  await page.addInitScript(() => {
    const own = [window.requestAnimationFrame.bind(window), window.setTimeout.bind(window)];
    const held = [];
    window.requestAnimationFrame = (act) => held.push(() => own[0](act));
    window.setTimeout = (act, ...more) => held.push(() => own[1](act, ...more));
    window.held = held;
    window.next_frame = own[0];
    window.soon = own[1];
    new MutationObserver(() => {
      if (document.documentElement.dataset.ready === "true") window.answered ??= performance.now();
    }).observe(document, { attributes: true, subtree: true });
  });
  await page.goto(pathToFileURL(page_file).href);
  await page.waitForFunction(() => window.answered, null, { polling: 100 });
  return { page, metrics, close: () => context.close() };
}

const answers = [];
const maps = [];
for (let i = 0; i < times; i++) {
  const { page, metrics, close } = await open_held();
  const before = await metrics();
  answers.push({ clock: await page.evaluate(() => window.answered), computed: before.ProcessTime });
  const clock = await show_held(page);
  maps.push({ clock, computed: (await metrics()).ProcessTime - before.ProcessTime });
  await close();
}
tell("opened, until the answer", answers);
tell("then, until the first map", maps);

/** Lets the frame go that shows the map, and waits until it is laid out. */
function show_held(page) {
  return page.evaluate(
    () =>
      new Promise((resolve) => {
        const start = performance.now();
        window.held.splice(0).forEach((act) => act());
        window.next_frame(() => {
          document.querySelector("#map").getBoundingClientRect();
          resolve(performance.now() - start);
        });
      }),
  );
}

const { page, metrics, close } = await open_held();
await show_held(page);
for (const [what, changes] of [
  ["a map of 500 columns, sampled controllers", "controller.sample_period = 0.001"],
  ["a map of 500 columns, continuous controllers", "controller.sample_period = 0"],
]) {
  const found = [];
  for (let i = 0; i < 2 * times; i++) {
    await page.evaluate((own) => window.telespring.page.open(window.telespring.engine.study(window.telespring.page.study(), own).toml), `${changes}\nrobot1.damping = ${5 + 0.01 * i}`);
    const before = await metrics();
    const clock = await show_held(page);
    await page.evaluate(() => void (window.held.length = 0));
    found.push({ clock, computed: (await metrics()).TaskDuration - before.TaskDuration });
  }
  // the first ones warm the compiler up
  tell(`${what}, shown`, found.slice(times));
}
await close();
await browser.close();
