// The page in a browser: what a newcomer, a keyboard, a screen reader and a telephone get.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { test } from "node:test";
import { looked, page_file, root, settled, study, unfold, values, with_browser } from "./browser.mjs";

const shots = process.env.SCREENSHOTS ?? null;
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const browser = with_browser();
const { open } = browser;

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

test("law_what_is_refused_is_said_and_leaves_the_study", looked, async () => {
  const { page, close } = await open();
  const before = await study(page);
  await page.fill("#stiffness", "0");
  assert.match(await page.textContent("#message"), /coupling\.stiffness/);
  assert.equal(await study(page), before);
  await page.fill("#stiffness", "90");
  assert.equal(await page.textContent("#message"), "");
  await close();
});

test("law_the_address_a_file_and_the_page_hold_the_same_study", looked, async () => {
  const { page, close } = await open();
  await page.fill("#stiffness", "123.4");
  await page.locator("#stiffness").blur();
  const shown = await study(page);
  const hash = await page.evaluate(() => location.hash);
  const again = await open({ hash });
  assert.equal(await study(again.page), shown);
  const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save")]);
  assert.equal(readFileSync(await download.path(), "utf8"), shown);
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
  const context = await browser.context();
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  await page.goto("about:blank");
  // a notebook's side of it: a model with the traits of the widget
  await page.evaluate(async ([text, html]) => {
    const { default: widget } = await import(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
    const heard = [];
    const traits = { _page: html, toml: "" };
    const set = (name, value) => {
      const isNew = traits[name] !== value;
      traits[name] = value;
      if (isNew) heard.forEach((call) => call());
    };
    const model = { get: (name) => traits[name], set, save_changes: () => {}, on: (_, call) => heard.push(call), off: () => {} };
    Object.assign(window, { traits, put: (value) => set("toml", value), show: () => widget.render({ model, el: document.body }) });
    window.show();
  }, [module, readFileSync(page_file, "utf8")]);
  await page.waitForFunction(() => /stiffness = 71.2/.test(window.traits.toml));
  const frame = page.frames()[1];
  await frame.fill("#stiffness", "88");
  await frame.locator("#stiffness").blur();
  await page.waitForFunction(() => /stiffness = 88/.test(window.traits.toml));
  await page.evaluate(() => window.put(window.traits.toml.replace("stiffness = 88", "stiffness = 44")));
  await frame.waitForFunction(() => document.querySelector("#stiffness").value === "44");
  // shown again, as in another cell: it opens with the study of now, and does not bring back that of the start
  await page.evaluate(() => window.show());
  await page.waitForFunction(() => window.frames.length === 2);
  // a frame below the window draws nothing: no frame of an animation to wait for
  const off = { polling: 100 };
  await page.frames()[2].waitForFunction(() => document.querySelector("#stiffness")?.value === "44", null, off);
  assert.match(await page.evaluate(() => window.traits.toml), /stiffness = 44/);
  await page.frames()[2].fill("#stiffness", "55");
  await page.frames()[2].locator("#stiffness").blur();
  await frame.waitForFunction(() => document.querySelector("#stiffness").value === "55", null, off);
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
    await unfold(page);
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
  assert.equal(await page.locator("#save-stability-map").isVisible(), false);
  assert.equal(await page.locator("#verdict").isVisible(), true);
  assert.equal(await page.evaluate(() => getComputedStyle(document.body).backgroundColor), "rgb(255, 255, 255)");
  if (shots) await page.pdf({ path: join(shots, "print.pdf") });
  await close();
});
