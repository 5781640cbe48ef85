// A drawing as a picture of its own: to save, and for the clipboard.

import { SPACE, html, svg } from "./svg.js";

const STYLES = ["fill", "stroke", "stroke-width", "stroke-dasharray", "opacity", "font-size", "font-family", "font-weight", "text-anchor"];

/** A drawing as text that needs no style sheet, with its colours of now on a background. */
export function standalone(drawing, background) {
  const copy = drawing.cloneNode(true);
  const originals = [drawing, ...drawing.querySelectorAll("*")];
  [copy, ...copy.querySelectorAll("*")].forEach((element, i) => {
    const own = getComputedStyle(originals[i]);
    if (own.display === "none") return element.setAttribute("display", "none");
    for (const style of STYLES) element.setAttribute(style, own.getPropertyValue(style));
    element.removeAttribute("class");
    element.removeAttribute("tabindex");
  });
  const [, , width, height] = drawing.getAttribute("viewBox").split(" ");
  copy.setAttribute("xmlns", SPACE);
  copy.setAttribute("width", width);
  copy.setAttribute("height", height);
  copy.prepend(svg("rect", { width, height, fill: background }));
  return new XMLSerializer().serializeToString(copy);
}

/** Pixels of a picture per unit of its drawing: sharp on paper and on a fine screen. */
const PIXELS = 2;

/** A drawing as a PNG picture, as it looks now. */
export async function pngOf(drawing, background) {
  const address = URL.createObjectURL(new Blob([standalone(drawing, background)], { type: "image/svg+xml" }));
  try {
    const image = html("img", { src: address, alt: "" });
    await image.decode();
    const canvas = html("canvas", { width: PIXELS * image.naturalWidth, height: PIXELS * image.naturalHeight });
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
    return await new Promise((resolve, reject) => {
      canvas.toBlob((picture) => (picture ? resolve(picture) : reject(new Error("this browser makes no picture"))), "image/png");
    });
  } finally {
    URL.revokeObjectURL(address);
  }
}
