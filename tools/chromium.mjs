// Where Chromium is: the file that the environment variable CHROMIUM names, else the first of these names on the PATH; undefined
// if there is none. tests/browser.py has the same rule, for Python.
import fs from "node:fs";
import path from "node:path";

const names = ["chromium", "chromium-browser", "google-chrome"];

export const chromium_file = process.env.CHROMIUM || names
  .flatMap((name) => (process.env.PATH ?? "").split(path.delimiter).map((folder) => path.join(folder, name)))
  .find((file) => fs.statSync(file, { throwIfNoEntry: false })?.isFile());
