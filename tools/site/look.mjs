// Looks at every page of the built site in Chromium, dark and light, on a desk and on a telephone:
//
//   node tools/site/look.mjs out/docs [PART-OF-A-PATH]
//
// It fails if axe-core finds a fault, a page scrolls sideways, a script fails, or a request leaves the page's folder.

import fs from "node:fs";
import path from "node:path";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const require = createRequire(new URL("../../docs/package.json", import.meta.url));
const { chromium } = require("playwright-core");
const axe = fs.readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

const site = path.resolve(process.argv[2] ?? "out/docs");
const wanted = process.argv[3] ?? "";
const browsers = ["chromium", "chromium-browser", "google-chrome"];
const executablePath = (process.env.PATH ?? "").split(":")
  .flatMap(folder => browsers.map(name => path.join(folder, name))).find(fs.existsSync);
if (!executablePath) {
  console.error("NO CHROMIUM HERE: nobody has seen whether the site can be read");
  process.exit(1);
}

// Of the pages that are made alike from docstrings, a few stand for all; the crate's pages are rustdoc's.
const ALIKE = ["_generated/python/telespring.decide.html", "_generated/python/telespring.Study.html"];
const pages = fs.readdirSync(site, { recursive: true })
  .filter(name => name.endsWith(".html") && !/^(rust|_static|_sources|_downloads)\//.test(name))
  .filter(name => !name.startsWith("_generated/python/") || ALIKE.includes(name))
  .filter(name => name !== "telespring.html" && name.includes(wanted)).sort();

const faults = [];
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
for (const [scheme, width] of [["light", 1200], ["dark", 400]]) {
  const context = await browser.newContext({ colorScheme: scheme, viewport: { width, height: 900 } });
  for (const name of pages) {
    const page = await context.newPage();
    const say = fault => {
      faults.push(fault);
      console.error(`${name} (${scheme}, ${width} px): ${fault}`);
    };
    page.on("pageerror", error => say(`script: ${error.message}`));
    page.on("request", request => {
      if (!/^(file|data|blob|about):/.test(request.url())) say(`request: ${request.url()}`);
    });
    page.on("requestfailed", request => {
      if (request.failure()?.errorText !== "net::ERR_ABORTED") say(`missing: ${request.url()} ${request.failure()?.errorText}`);
    });
    await page.goto(pathToFileURL(path.join(site, name)).href);
    const { scrollWidth, innerWidth } = await page.evaluate(
      () => ({ scrollWidth: document.documentElement.scrollWidth, innerWidth }));
    if (scrollWidth > innerWidth) say(`scrolls sideways: ${scrollWidth} px wide`);
    await page.evaluate(axe);
    // the interactive page in its frame is checked where it is made
    const found = await page.evaluate(() => window.axe.run({ exclude: ["iframe"] }, { preload: false }));
    for (const each of found.violations) {
      say(`${each.impact} ${each.id}: ${each.nodes.map(node => node.target.join(" ")).slice(0, 4).join(" | ")}`);
    }
    await page.close();
  }
  await context.close();
}
await browser.close();

console.log(`${pages.length} pages, each dark and light: ${faults.length} faults`);
process.exit(faults.length ? 1 : 0);
