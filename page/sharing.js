// A study and its pictures in and out of the page: files, a link, the clipboard.

import { toHash } from "./link.js";
import { pngOf, standalone } from "./picture.js";
import { html } from "./svg.js";

/** No study is larger, bytes: as the core reads at most. */
const LARGEST = 2 ** 20;

/** Hands a file to the reader. */
function download(name, content, type) {
  const link = html("a", { href: URL.createObjectURL(new Blob([content], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Copies a text, in the old way where the new one is not allowed; returns whether it is copied. */
async function copyText(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const focused = document.activeElement;
    const area = html("textarea", { value: text });
    document.body.append(area);
    area.select();
    const isCopied = document.execCommand("copy");
    area.remove();
    focused?.focus();
    return isCopied;
  }
}

/**
 * Two buttons for a drawing: one copies it as a picture, the other saves it. `drawing` finds it when it is asked for, `name`
 * is what the buttons call it, `what` the same for a reader who does not see where they stand.
 */
function createPictureButtons({ drawing, file, name = "the picture", what }, message) {
  const background = () => getComputedStyle(document.body).getPropertyValue("--card").trim() || "white";
  const save = (name, content, type) => {
    download(name, content, type);
    message.say(`${name} is saved.`);
  };
  const button = (id, verb, act) => {
    const made = html("button", { type: "button", id: `${id}-${file}`, "aria-label": `${verb} ${name}: ${what}` }, `${verb} ${name}`);
    made.addEventListener("click", () => drawing() && act());
    return made;
  };
  const copy = async () => {
    const png = pngOf(drawing(), background());
    png.catch(() => {});
    try {
      // a promise: a browser may ask the reader first
      await navigator.clipboard.write([new ClipboardItem({ "image/png": png })]);
      message.say(`The picture is copied: ${what}.`);
    } catch {
      message.offer("This browser lets the page copy no picture.", "Save it as a PNG file", async () => {
        try {
          save(`${file}.png`, await png, "image/png");
        } catch (error) {
          message.warn(`The picture cannot be made: ${error.message}. The other button saves a drawing (SVG).`);
        }
      });
    }
  };
  return [
    button("copy", "Copy", copy),
    button("save", "Save", () => save(`${file}.svg`, standalone(drawing(), background()), "image/svg+xml")),
  ];
}

/** Adds the buttons of each drawing to its place. */
export function addPictureButtons(part, region, message) {
  const motion = (i) => () => part("motion").querySelectorAll("figure svg")[i];
  const pictures = [
    ["map-buttons", { drawing: () => region.drawing(), file: "stability-map", what: "the map" }],
    ["motion-buttons", { drawing: motion(0), file: "motion-spring", name: "the bare spring's picture", what: "the motion" }],
    ["motion-buttons", { drawing: motion(1), file: "motion-guard", name: "the guard's picture", what: "the motion" }],
    ["nyquist-buttons", { drawing: () => part("nyquist").querySelector("svg"), file: "nyquist-locus", what: "the Nyquist locus" }],
    ["roots-buttons", { drawing: () => part("roots").querySelector("svg"), file: "root-locus", what: "the root locus" }],
  ];
  for (const [place, picture] of pictures) part(place).append(...createPictureButtons(picture, message));
}

/** Wires what takes a study in and out; `open` takes a text, `study` gives one. */
export function wireSharing(part, message, { open, openStart, study, isInside }) {
  const openFile = async (file) => {
    if (!file) return;
    if (file.size > LARGEST) return message.warn(`${file.name} is too large: a study has at most 1 MiB.`);
    let text;
    try {
      text = await file.text();
    } catch {
      // a folder, or a file that is gone
      return message.warn(`${file.name} cannot be read: a study is one file.`);
    }
    // an empty text is the paper's study, an empty file is none
    if (!open(text || "\n")) return;
    const left = message.text();
    message.say(`Opened ${file.name}.${left && ` ${left}`}`);
  };
  const copy = async (text, what) => {
    if (await copyText(text)) message.say(`${what} is copied.`);
    else message.warn(`This browser lets the page copy nothing. ${what}: ${text}`);
  };
  part("open").addEventListener("click", () => part("file").click());
  part("file").addEventListener("change", async () => {
    await openFile(part("file").files[0]);
    part("file").value = "";
  });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    openFile(event.dataTransfer?.files[0]);
  });
  part("save").addEventListener("click", () => {
    download("study.toml", study(), "application/toml");
    message.say("study.toml is saved.");
  });
  part("paper").addEventListener("click", openStart);
  // a page inside another has no address of its own
  part("link").hidden = isInside;
  part("link").addEventListener("click", () => copy(location.href.split("#")[0] + toHash(study()), "The link"));
  part("copy-command").addEventListener("click", () => copy(part("command").textContent, "The command"));
}
