// Looks at every page of the built site in Chromium, light on a desk and dark on a telephone:
//
//   node tools/site/look.mjs out/docs [PART-OF-A-PATH]
//
// It fails if axe-core finds a fault, a page scrolls sideways, a script fails, or a request leaves the page's folder.
// With SCREENSHOTS=FOLDER it keeps a picture of each page.

import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";
import { chromium_file } from "../chromium.mjs";

const require = createRequire(new URL("../../docs/package.json", import.meta.url));
const { chromium } = require("playwright-core");
const axe = fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

const site = path.resolve(process.argv[2] ?? "out/docs");
const wanted = process.argv[3] ?? "";
const shots = process.env.SCREENSHOTS;
const looks = [["light", 1200], ["dark", 400]];
if (!chromium_file) {
  console.error("NO CHROMIUM HERE: nobody has seen whether the site can be read");
  process.exit(1);
}

// Of the pages that are made alike from docstrings, a few stand for all; the crate's pages are rustdoc's.
const ALIKE = ["_generated/python/telespring.decide.html", "_generated/python/telespring.Study.html"];
const pages = fs.readdirSync(site, { recursive: true })
  .filter(name => name.endsWith(".html") && !/^(rust|_static|_sources|_downloads)\//.test(name))
  .filter(name => !name.startsWith("_generated/python/") || ALIKE.includes(name))
  .filter(name => name !== "telespring.html" && name.includes(wanted)).sort();
if (!pages.length) {
  console.error(`no page in ${site}: 'make docs' makes the site`);
  process.exit(1);
}

let faults = 0;

/** Looks at pages of the list, one after the other in one tab, until there is none left. */
async function look(browser, list) {
  const context = await browser.newContext();
  const tab = await context.newPage();
  let where = "";
  const say = fault => {
    faults += 1;
    console.error(`${where}: ${fault}`);
  };
  tab.on("pageerror", error => say(`script: ${error.message}`));
  tab.on("request", request => {
    if (!/^(file|data|blob|about):/.test(request.url())) say(`request: ${request.url()}`);
  });
  tab.on("requestfailed", request => {
    if (request.failure()?.errorText !== "net::ERR_ABORTED") say(`missing: ${request.url()} ${request.failure()?.errorText}`);
  });
  for (let name = list.shift(); name !== undefined; name = list.shift()) {
    for (const [scheme, width] of looks) {
      where = `${name} (${scheme}, ${width} px)`;
      // the theme follows the scheme when a page opens, so that each look opens it anew
      await tab.setViewportSize({ width, height: 900 });
      await tab.emulateMedia({ colorScheme: scheme });
      await tab.goto(pathToFileURL(path.join(site, name)).href);
      const sideways = await tab.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      if (sideways > 0) say(`scrolls sideways by ${sideways} px`);
      await tab.evaluate(axe);
      // the interactive page in its frame is checked where it is made
      const violations = await tab.evaluate(async () => {
        const found = await window.axe.run({ exclude: ["iframe"] }, { preload: false, resultTypes: ["violations"] });
        return found.violations.map(({ impact, id, nodes }) => ({ impact, id, targets: nodes.map(node => node.target.join(" ")) }));
      });
      for (const { impact, id, targets } of violations) say(`${impact} ${id}: ${targets.slice(0, 4).join(" | ")}`);
      if (shots) await tab.screenshot({ path: path.join(shots, `${name.replaceAll("/", "-")}-${scheme}.png`) });
    }
  }
  await context.close();
}

const begin = performance.now();
if (shots) fs.mkdirSync(shots, { recursive: true });
const browser = await chromium.launch({ executablePath: chromium_file, args: ["--no-sandbox"] });
const left = [...pages];
await Promise.all(Array.from({ length: Math.min(4, os.availableParallelism()) }, () => look(browser, left)));
await browser.close();

const seconds = Math.round((performance.now() - begin) / 1000);
console.log(`${pages.length} pages, each light and dark: ${faults} faults (${seconds} s)`);
process.exit(faults ? 1 : 0);
