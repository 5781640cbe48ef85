// The page in a browser: what a newcomer, a keyboard, a screen reader and a telephone get.
//
// Needs out/page/telespring.html ('make page') and Chromium; skips loudly without either. The command line's answers come
// from TELESPRING, the command to run, split at spaces.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
const page_file = join(root, "out/page/telespring.html");
const browser_file = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((path) => path && existsSync(path));
const missing = !existsSync(page_file) ? "no out/page/telespring.html: run 'make page'" : !browser_file ? "no Chromium" : null;
if (missing) console.error(`SKIPPED: the page is not looked at: ${missing}`);
const telespring = process.env.TELESPRING?.split(" ") ?? null;
if (!telespring) console.error("SKIPPED: TELESPRING is not set: the page is not compared with the command line");
const shots = process.env.SCREENSHOTS ?? null;
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

let browser;
before(async () => {
  if (!missing) browser = await chromium.launch({ executablePath: browser_file, args: ["--no-sandbox"] });
});
after(() => browser?.close());

/** A page that is ready; every request that would leave it, and every error, is kept. */
async function open({ hash = "", width = 1200, height = 900, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  const requests = [];
  const errors = [];
  page.on("request", (request) => requests.push(request.url()));
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  await page.goto(pathToFileURL(page_file).href + hash);
  await page.waitForFunction(() => document.documentElement.dataset.ready === "true");
  return { page, requests, errors, close: () => context.close() };
}

const looked = { skip: missing ?? false, timeout: 240_000 };
const answer = (page) => page.evaluate(() => window.telespring.page.state().answer);
const values = (page) => page.evaluate(() => window.telespring.page.state().values);
const settled = (page) => page.waitForFunction(() => document.querySelectorAll("#verdicts tr").length > 5 && document.querySelector("#nyquist svg") && document.querySelector("#motion svg path"));

/** What `telespring decide --json` says for the command that the page shows. */
function decided(command) {
  const [name, ...words] = command.split(" ");
  assert.equal(name, "telespring");
  const [program, ...first] = telespring;
  return JSON.parse(execFileSync(program, [...first, ...words, "--json"], { encoding: "utf8", cwd: root }));
}

const close_to = (one, other) => one === other || Math.abs(one - other) <= 1e-9 * Math.max(Math.abs(one), Math.abs(other));

/** Every value that both answers have must be the same, numbers to 1e-9. */
function assert_same(page, command, where = "") {
  if (page === null || typeof page !== "object") {
    const same = typeof page === "number" && typeof command === "number" ? close_to(page, command) : page === command;
    assert.ok(same, `${where}: ${page} on the page, ${command} by the command`);
    return;
  }
  for (const key of Object.keys(page)) if (command !== null && key in command) assert_same(page[key], command[key], `${where}.${key}`);
}

test("law_a_newcomer_sees_the_verdict_the_margin_and_the_map", looked, async () => {
  const { page, errors, close } = await open();
  assert.equal(await page.textContent("#verdict"), "Stable");
  assert.match(await page.textContent("#margin"), /stiffness may grow by .* N\/m\. The delay may grow by .* ms each way/);
  for (const part of ["#verdict", "#margin", "#map .point .star"]) {
    const box = await page.locator(part).boundingBox();
    assert.ok(box.y >= 0 && box.y + box.height <= 900, `${part} is below the first screen`);
  }
  await settled(page);
  assert.deepEqual(errors, []);
  if (shots) {
    mkdirSync(shots, { recursive: true });
    await page.screenshot({ path: join(shots, "light.png"), fullPage: true });
  }
  await close();
});

test("law_no_request_leaves_the_page", looked, async () => {
  const { page, requests, errors, close } = await open();
  await settled(page);
  await page.click("#motion button.primary");
  await page.waitForTimeout(500);
  const outside = requests.filter((url) => !/^(file|blob|data):/.test(url));
  assert.deepEqual(outside, []);
  // what the page's own policy stops is an error on its console
  assert.deepEqual(errors, []);
  assert.equal(requests.filter((url) => url.startsWith("file:")).length, 1);
  await close();
});

test("cross_a_moved_slider_gives_the_answer_of_the_command_line", { ...looked, skip: missing ?? (telespring ? false : "TELESPRING is not set") }, async () => {
  const { page, close } = await open();
  const slide = (label, share) =>
    page.getByLabel(label, { exact: true }).first().evaluate((slider, at) => {
      slider.value = String(Math.round(at * 1000));
      slider.dispatchEvent(new Event("input", { bubbles: true }));
      slider.dispatchEvent(new Event("change", { bubbles: true }));
    }, share);
  for (const moves of [
    [["Stiffness of the spring, slider", 0.75]],
    [["Delay each way, slider", 0.5], ["Sample period of the controllers, slider", 0]],
    [["Jitter, slider", 0.7]],
    [["Damping, axis x, slider", 0.4], ["Jitter, slider", 0], ["Grip stiffness, most, slider", 0.6]],
  ]) {
    for (const [label, share] of moves) {
      await page.evaluate(() => document.querySelectorAll("details").forEach((group) => (group.open = true)));
      await slide(label, share);
    }
    const own = await answer(page);
    const command = decided(await page.textContent("#command"));
    assert_same(own, command);
    assert.equal((await page.textContent("#verdict")).toLowerCase(), worst(command));
  }
  await close();
});

const order = ["stable", "marginal", "not proven", "unstable"];
const worst = (found) => [found, found.free].filter(Boolean).map((each) => each.status).sort((a, b) => order.indexOf(b) - order.indexOf(a))[0];

test("law_every_control_works_by_keyboard", looked, async () => {
  const { page, close } = await open();
  await page.evaluate(() => document.querySelectorAll("details").forEach((group) => (group.open = true)));
  const sliders = await page.locator("#controls input[type=range]").count();
  assert.ok(sliders > 10);
  for (let i = 0; i < sliders; i++) {
    const slider = page.locator("#controls input[type=range]").nth(i);
    await slider.focus();
    const before = await page.evaluate(() => window.telespring.page.study());
    await page.keyboard.press("ArrowRight");
    const after_keys = await page.evaluate(() => window.telespring.page.study());
    assert.notEqual(after_keys, before, `slider ${i} changes nothing`);
    assert.ok(await slider.getAttribute("aria-valuetext"));
    await page.keyboard.press("ArrowLeft");
  }
  // the point of the map
  await page.locator("#map .point").focus();
  const { stiffness } = await values(page);
  await page.keyboard.press("ArrowRight");
  assert.ok((await values(page)).stiffness > stiffness);
  // what has the focus is seen, and all of it can be reached by Tab
  const reached = new Set();
  await page.evaluate(() => document.activeElement.blur());
  for (let press = 0; press < 120; press++) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => document.activeElement.id || document.activeElement.className.baseVal || document.activeElement.textContent.slice(0, 30)));
  }
  for (const id of ["stiffness", "delay", "jitter", "sample-period", "playout-buffer", "mass-1-0", "damping-2-0", "grip-stiffness-1-1", "open", "save", "link", "paper", "axis", "copy-command", "picture", "point"]) {
    assert.ok(reached.has(id), `Tab does not reach ${id}`);
  }
  await close();
});

test("law_what_is_refused_is_said_and_leaves_the_study", looked, async () => {
  const { page, close } = await open();
  const before = await page.evaluate(() => window.telespring.page.study());
  await page.fill("#stiffness", "0");
  assert.match(await page.textContent("#message"), /coupling\.stiffness/);
  assert.equal(await page.evaluate(() => window.telespring.page.study()), before);
  await page.fill("#stiffness", "90");
  assert.equal(await page.textContent("#message"), "");
  await close();
});

test("law_the_address_a_file_and_the_page_hold_the_same_study", looked, async () => {
  const { page, close } = await open();
  await page.fill("#stiffness", "123.4");
  await page.locator("#stiffness").blur();
  const study = await page.evaluate(() => window.telespring.page.study());
  const hash = await page.evaluate(() => location.hash);
  const again = await open({ hash });
  assert.equal(await again.page.evaluate(() => window.telespring.page.study()), study);
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save")]);
  assert.equal(readFileSync(await download.path(), "utf8"), study);
  await again.page.setInputFiles("#file", join(root, "examples/guard.toml"));
  await again.page.waitForFunction(() => window.telespring.page.state().values.session.startsWith("guard"));
  assert.equal((await values(again.page)).stiffness, 142);
  assert.match(await again.page.textContent("#command"), /study\.toml/);
  await again.close();
  const damaged = await open({ hash: "#study=bm9uc2Vuc2UgPSAx" });
  assert.match(await damaged.page.textContent("#message"), /refused/);
  assert.equal(await damaged.page.textContent("#verdict"), "Stable");
  await damaged.close();
  await close();
});

test("law_a_hostile_study_runs_nothing", looked, async () => {
  const { page, errors, close } = await open();
  await page.evaluate(() => window.telespring.page.open('name = "<img src=x onerror=window.hit=1>"\n[robot1]\nname = "<script>window.hit=1</script>"\nmass = 1\ndamping = 5\n[robot2]\nmass = 1\ndamping = 5\n'));
  await settled(page);
  assert.equal(await page.evaluate(() => window.hit), undefined);
  assert.match(await page.textContent("#controls"), /<script>/);
  assert.deepEqual(errors, []);
  await close();
});

test("law_the_map_marks_what_an_attack_reaches", looked, async () => {
  const { page, close } = await open();
  await page.fill("#jitter", "30");
  await page.locator("#jitter").blur();
  await page.waitForFunction(() => document.querySelector("#map .proven"));
  await page.click("#attack");
  await page.waitForFunction(() => document.querySelector("#map .attack-mark"), null, { timeout: 200_000 });
  const [found] = await page.evaluate(() => window.telespring.page.state().attacks);
  const bound = await page.evaluate((delay) => window.telespring.engine.bounds(window.telespring.page.study(), delay), found.delay);
  assert.ok(found.stiffness > bound.age_in_a_range);
  await close();
});

test("law_the_guard_calms_the_robots_on_the_page", looked, async () => {
  const { page, close } = await open();
  await page.fill("#stiffness", "250");
  await page.locator("#stiffness").blur();
  await page.waitForFunction(() => /Bare spring: the (?:robots shake|distance.*it grows)/.test(document.querySelector("#motion .reading").textContent));
  assert.match(await page.textContent("#motion .reading"), /Guard: .*dies away/);
  assert.equal(await page.textContent("#verdict"), "Unstable");
  await close();
});

test("law_a_notebook_and_the_page_in_its_frame_tell_each_other", looked, async () => {
  const source = readFileSync(join(root, "python/telespring/app/widget.py"), "utf8");
  const module = source.match(/_MODULE = """\n([^]*?)"""/)[1];
  const context = await browser.newContext();
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  await page.goto("about:blank");
  // a notebook's side of it: a model with the traits of the widget
  await page.evaluate(async ([text, html]) => {
    const { default: widget } = await import(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
    const heard = {};
    const traits = { _page: html, toml: "" };
    const model = { get: (name) => traits[name], set: (name, value) => (traits[name] = value), save_changes: () => (traits.saved = (traits.saved ?? 0) + 1), on: (name, call) => (heard[name] = call), off: () => {} };
    Object.assign(window, { traits, put: (value) => ((traits.toml = value), heard["change:toml"]()) });
    widget.render({ model, el: document.body });
  }, [module, readFileSync(page_file, "utf8")]);
  await page.waitForFunction(() => /stiffness = 71.2/.test(window.traits.toml));
  const frame = page.frames()[1];
  await frame.fill("#stiffness", "88");
  await frame.locator("#stiffness").blur();
  await page.waitForFunction(() => /stiffness = 88/.test(window.traits.toml));
  await page.evaluate(() => window.put(window.traits.toml.replace("stiffness = 88", "stiffness = 44")));
  await frame.waitForFunction(() => document.querySelector("#stiffness").value === "44");
  await context.close();
});

for (const [name, options] of [
  ["light", {}],
  ["dark", { colorScheme: "dark" }],
  ["telephone", { width: 400, height: 800 }],
  ["unstable_and_varying", { setup: { "#stiffness": "300", "#jitter": "20" } }],
]) {
  test(`cross_axe_core_finds_no_fault_${name}`, looked, async () => {
    const { setup = {}, ...rest } = options;
    const { page, close } = await open(rest);
    for (const [field, value] of Object.entries(setup)) await page.fill(field, value);
    await page.evaluate(() => document.querySelectorAll("details").forEach((group) => (group.open = true)));
    await settled(page);
    // the page's own policy lets nothing in, not even a test's script: it runs apart from the page
    await page.evaluate(axe);
    const found = await page.evaluate(() => window.axe.run());
    assert.deepEqual(found.violations.map((each) => [each.id, each.nodes.map((node) => [node.target.join(" "), node.failureSummary])]), []);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), "the page scrolls sideways");
    if (shots) {
      mkdirSync(shots, { recursive: true });
      await page.screenshot({ path: join(shots, `${name}.png`), fullPage: true });
    }
    await close();
  });
}

test("law_on_paper_the_page_keeps_its_answer", looked, async () => {
  const { page, close } = await open({ colorScheme: "dark" });
  await settled(page);
  await page.emulateMedia({ media: "print" });
  assert.equal(await page.locator("#picture").isVisible(), false);
  assert.equal(await page.locator("#verdict").isVisible(), true);
  assert.equal(await page.evaluate(() => getComputedStyle(document.body).backgroundColor), "rgb(255, 255, 255)");
  if (shots) await page.pdf({ path: join(shots, "print.pdf") });
  await close();
});
