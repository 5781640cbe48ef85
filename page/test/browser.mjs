// The page in a browser, for the tests: opened, and asked.
//
// Needs out/page/telespring.html ('make page') and Chromium; what lacks them skips loudly. The command line's answers come
// from TELESPRING, the command to run, split at spaces.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { dirname, join } from "node:path";
import { after, before } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";
import { chromium_file } from "../../tools/chromium.mjs";

export const root = join(dirname(fileURLToPath(import.meta.url)), "../..");
export const page_file = join(root, "out/page/telespring.html");
const missing = !existsSync(page_file) ? "no out/page/telespring.html: run 'make page'" : !chromium_file ? "no Chromium" : null;
const telespring = process.env.TELESPRING?.split(" ") ?? null;

/** What a test needs that looks at the page, and one that compares it with the command line. */
export const looked = { skip: missing ?? false, timeout: 240_000 };
export const compared = { ...looked, skip: missing ?? (telespring ? false : "TELESPRING is not set") };
for (const reason of new Set([looked.skip, compared.skip])) if (reason) console.error(`SKIPPED: the page is not looked at, or not compared: ${reason}`);

/** Starts the browser for the tests of a file; returns the way to open a page in it. */
export function with_browser() {
  let browser;
  before(async () => {
    if (!missing) browser = await launch();
  });
  after(() => browser?.close());
  const open = (options) => open_in(browser, options);
  return { open, context: () => browser.newContext() };
}

/** A browser. */
export const launch = () => chromium.launch({ executablePath: chromium_file, args: ["--no-sandbox"] });

/** A page that is ready; every request that would leave it, and every error, is kept. `first` runs in it before anything else. */
async function open_in(browser, { hash = "", width = 1200, height = 900, first = null, ...options } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(60_000);
  const requests = [];
  const errors = [];
  page.on("request", (request) => requests.push(request.url()));
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  if (first) await page.addInitScript(first);
  await page.goto(pathToFileURL(page_file).href + hash);
  await page.waitForFunction(() => document.documentElement.dataset.ready === "true");
  return { page, requests, errors, close: () => context.close() };
}

export const study = (page) => page.evaluate(() => window.telespring.page.study());
export const answer = (page) => page.evaluate(() => window.telespring.page.state().answer);
export const values = (page) => page.evaluate(() => window.telespring.page.state().values);
export const settled = (page) => page.waitForFunction(() => document.querySelectorAll("#verdicts tr").length > 5 && document.querySelector("#nyquist svg") && document.querySelector("#motion svg path"));
export const unfold = (page) => page.evaluate(() => document.querySelectorAll("details").forEach((group) => (group.open = true)));

/** What `telespring decide --json` says for the command that the page shows. */
export function decided(command) {
  const [name, ...words] = command.split(" ");
  assert.equal(name, "telespring");
  const [program, ...first] = telespring;
  return JSON.parse(execFileSync(program, [...first, ...words, "--json"], { encoding: "utf8", cwd: root }));
}

const close_to = (one, other) => one === other || Math.abs(one - other) <= 1e-9 * Math.max(Math.abs(one), Math.abs(other));

/** Every value that both answers have must be the same, numbers to 1e-9. */
export function assert_same(page, command, where = "") {
  if (page === null || typeof page !== "object") {
    const same = typeof page === "number" && typeof command === "number" ? close_to(page, command) : page === command;
    assert.ok(same, `${where}: ${page} on the page, ${command} by the command`);
    return;
  }
  for (const key of Object.keys(page)) if (command !== null && key in command) assert_same(page[key], command[key], `${where}.${key}`);
}

const order = ["stable", "marginal", "not proven", "unstable"];

/** The word for held and free handles together. */
export const worst = (found) => [found, found.free].filter(Boolean).map((each) => each.status).sort((a, b) => order.indexOf(b) - order.indexOf(a))[0];
