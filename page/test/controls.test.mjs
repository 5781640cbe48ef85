// The controls and what leaves the page: each value by slider, number and keyboard, and the pictures.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { answer, assert_same, compared, decided, looked, settled, study, unfold, values, with_browser, worst } from "./browser.mjs";

const { open } = with_browser();

/** Moves a slider to a share of its way. */
const slide = (page, label, share) =>
  page.getByLabel(label, { exact: true }).first().evaluate((slider, at) => {
    slider.value = String(Math.round(at * 1000));
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    slider.dispatchEvent(new Event("change", { bubbles: true }));
  }, share);

test("cross_a_moved_slider_gives_the_answer_of_the_command_line", compared, async () => {
  const { page, close } = await open();
  await unfold(page);
  for (const moves of [
    [["Stiffness of the spring, slider", 0.75]],
    [["Computing time of a controller, slider", 0.4], ["Damping of the coupling, slider", 0.3]],
    [["Delay each way, slider", 0.5], ["Sample period of the controllers, slider", 0]],
    [["Jitter, slider", 0.7], ["Longest gap in the network, slider", 0.4]],
    [["Damping, axis x, slider", 0.4], ["Jitter, slider", 0], ["Longest gap in the network, slider", 0], ["Damping of the coupling, slider", 0], ["Grip stiffness, most, slider", 0.6]],
  ]) {
    for (const [label, share] of moves) await slide(page, label, share);
    const own = await answer(page);
    const command = decided(await page.textContent("#command"));
    assert_same(own, command);
    assert.equal((await page.textContent("#verdict")).toLowerCase(), worst(command));
  }
  await close();
});

test("law_the_rarer_values_are_in_the_study_the_address_and_the_command", looked, async () => {
  const { page, close } = await open();
  await unfold(page);
  for (const [field, value] of [["#max-gap", "12.5"], ["#computing-time", "0.4"], ["#coupling-damping", "3"]]) {
    await page.fill(field, value);
    await page.locator(field).blur();
  }
  const own = await values(page);
  assert.deepEqual([own.max_gap, own.computing_time, own.coupling_damping], [0.0125, 0.0004, 3]);
  assert.match(await page.textContent("#command"), /--max-gap 0\.0125 .*--computing-time 0\.0004 --coupling-damping 3$/);
  const again = await open({ hash: await page.evaluate(() => location.hash) });
  assert.equal(await study(again.page), await study(page));
  assert.equal(await again.page.inputValue("#computing-time"), "0.4");
  // a controller computes within its period; a continuous one computes in no time
  await page.fill("#sample-period", "0.2");
  assert.equal((await values(page)).computing_time, 0.0002);
  await page.fill("#sample-period", "0");
  assert.equal((await values(page)).computing_time, 0);
  assert.ok(await page.locator("#computing-time").isDisabled());
  await again.close();
  await close();
});

test("law_ways_and_axes_are_set_apart_and_made_alike_again", looked, async () => {
  const { page, close } = await open();
  await unfold(page);
  await page.check("#own-ways");
  assert.ok(await page.evaluate(() => document.activeElement.id === "own-ways"), "the focus is lost");
  await page.fill("#delay-2", "40");
  await page.fill("#jitter-1", "7");
  let own = await values(page);
  assert.deepEqual([own.delay, own.jitter], [[0.1, 0.04], [0.007, 0]]);
  assert.match(await page.textContent("#command"), /study\.toml/);
  await page.uncheck("#own-ways");
  own = await values(page);
  assert.deepEqual([own.delay, own.jitter], [[0.1, 0.1], [0.007, 0.007]]);
  await page.check("#own-grips");
  await page.fill("#grip-stiffness-1-1-1", "80");
  own = await values(page);
  assert.deepEqual(own.operators[0].stiffness, [[0, 0], [0, 80]]);
  await page.uncheck("#own-grips");
  assert.deepEqual((await values(page)).operators[0].stiffness, [[0, 0], [0, 0]]);
  await page.fill("#ground-stiffness-2-0", "25");
  assert.deepEqual((await values(page)).robots[1].ground_stiffness, [25, 0]);
  await close();
});

test("law_unusual_values_are_refused_until_they_are_allowed", looked, async () => {
  const { page, close } = await open();
  await unfold(page);
  await page.fill("#delay", "3000");
  assert.match(await page.textContent("#message.refusal"), /network\.delay/);
  await page.fill("#delay", "100");
  await page.check("#allow-unusual");
  await page.fill("#delay", "3000");
  assert.equal(await page.textContent("#message"), "");
  assert.deepEqual((await values(page)).delay, [3, 3]);
  assert.match(await page.textContent("#command"), /--allow-unusual$/);
  // the study needs it now: the box stays as the study is
  await page.evaluate(() => document.querySelector("#allow-unusual").click());
  assert.match(await page.textContent("#message.refusal"), /network\.delay/);
  assert.ok(await page.isChecked("#allow-unusual"));
  await close();
});

test("law_every_control_works_by_keyboard", looked, async () => {
  const { page, close } = await open();
  await unfold(page);
  const sliders = await page.locator("#controls input[type=range]").count();
  assert.ok(sliders > 30);
  for (let i = 0; i < sliders; i++) {
    const slider = page.locator("#controls input[type=range]").nth(i);
    await slider.focus();
    const before = await study(page);
    await page.keyboard.press("ArrowRight");
    const after_keys = await study(page);
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
  for (let press = 0; press < 200; press++) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => document.activeElement.id || document.activeElement.className.baseVal || document.activeElement.textContent.slice(0, 30)));
  }
  for (const id of ["stiffness", "delay", "jitter", "sample-period", "playout-buffer", "mass-1-0", "damping-2-0", "grip-stiffness-1-1", "open", "save", "link", "paper", "axis", "copy-command", "copy-stability-map", "save-root-locus", "max-gap", "computing-time", "coupling-damping", "own-ways", "allow-unusual", "ground-stiffness-1-0", "point"]) {
    assert.ok(reached.has(id), `Tab does not reach ${id}`);
  }
  await close();
});

const pictures = ["stability-map", "motion-spring", "motion-guard", "nyquist-locus", "root-locus"];

test("law_every_picture_is_copied_and_saved", looked, async () => {
  const { page, errors, close } = await open({ permissions: ["clipboard-read", "clipboard-write"] });
  await settled(page);
  for (const name of pictures) {
    await page.click(`#copy-${name}`);
    await page.waitForFunction(() => /is copied/.test(document.querySelector("#message").textContent));
    const found = await page.evaluate(async () => {
      const [item] = await navigator.clipboard.read();
      const picture = await createImageBitmap(await item.getType("image/png"));
      const canvas = new OffscreenCanvas(picture.width, picture.height);
      const context = canvas.getContext("2d");
      context.drawImage(picture, 0, 0);
      const pixels = new Uint32Array(context.getImageData(0, 0, picture.width, picture.height).data.buffer);
      return { width: picture.width, colours: new Set(pixels).size };
    });
    assert.ok(found.width >= 600 && found.colours > 20, `${name}: ${JSON.stringify(found)}`);
    await page.evaluate(() => document.querySelector("#message").replaceChildren());
    const [download] = await Promise.all([page.waitForEvent("download"), page.click(`#save-${name}`)]);
    assert.equal(download.suggestedFilename(), `${name}.svg`);
    const saved = readFileSync(await download.path(), "utf8");
    assert.match(saved, /^<svg [^>]*xmlns="http:\/\/www\.w3\.org\/2000\/svg"/);
    assert.doesNotMatch(saved, /class=/);
  }
  assert.deepEqual(errors, []);
  await close();
});

test("law_without_a_clipboard_the_picture_is_offered_as_a_file", looked, async () => {
  const { page, errors, close } = await open({ first: () => Object.defineProperty(navigator, "clipboard", { value: undefined }) });
  await settled(page);
  await page.click("#copy-stability-map");
  const button = page.getByRole("button", { name: "Save it as a PNG file" });
  const [download] = await Promise.all([page.waitForEvent("download"), button.click()]);
  assert.equal(download.suggestedFilename(), "stability-map.png");
  assert.deepEqual([...readFileSync(await download.path()).subarray(0, 4)], [0x89, 0x50, 0x4e, 0x47]);
  assert.deepEqual(errors, []);
  await close();
});
