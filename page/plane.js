// Two axes with ticks and labels, and the way from values to places on a drawing.

import { digits, ticks } from "./numbers.js";
import { svg } from "./svg.js";

/** A drawing with axes. `x` and `y` are {from, to, label, factor}: shown is the value times its factor. */
export function plane({ width, height, x, y, label, description }) {
  const left = 58, right = 18, top = 12, bottom = 44;
  const inner = { width: width - left - right, height: height - top - bottom };
  const id = `plane-${(plane.count = (plane.count ?? 0) + 1)}`;
  const drawing = svg("svg", { viewBox: `0 0 ${width} ${height}`, class: "drawing", role: "group", "aria-labelledby": `${id}-title ${id}-description` });
  const title = svg("title", { id: `${id}-title` }, label);
  const about = svg("desc", { id: `${id}-description` }, description);
  const clip = svg("clipPath", { id: `${id}-clip` }, svg("rect", { x: left, y: top, width: inner.width, height: inner.height }));
  const toX = (value) => left + ((value - x.from) / (x.to - x.from)) * inner.width;
  const toY = (value) => top + inner.height - ((value - y.from) / (y.to - y.from)) * inner.height;
  const content = svg("g", { "clip-path": `url(#${id}-clip)` });
  const above = svg("g");
  const axes = svg("g", { class: "axes", "aria-hidden": "true" });
  const marks = (axis, most) => ticks((axis.to - axis.from) * axis.factor, most).map((tick) => axis.from + tick / axis.factor);
  const evenly = (axis, most) => {
    if (axis.from === 0) return marks(axis, most);
    const step = ticks((axis.to - axis.from) * axis.factor, most)[1] / axis.factor;
    const found = [];
    for (let at = Math.ceil(axis.from / step) * step; at <= axis.to + 1e-9 * step; at += step) found.push(Math.abs(at) < 1e-9 * step ? 0 : at);
    return found;
  };
  for (const value of evenly(x, width < 480 ? 5 : 7)) {
    axes.append(
      svg("line", { x1: toX(value), x2: toX(value), y1: top, y2: top + inner.height, class: "grid" }),
      svg("text", { x: toX(value), y: top + inner.height + 16, "text-anchor": "middle" }, digits(value * x.factor)),
    );
  }
  for (const value of evenly(y, 6)) {
    axes.append(
      svg("line", { x1: left, x2: left + inner.width, y1: toY(value), y2: toY(value), class: "grid" }),
      svg("text", { x: left - 6, y: toY(value) + 4, "text-anchor": "end" }, digits(value * y.factor)),
    );
  }
  axes.append(
    svg("rect", { x: left, y: top, width: inner.width, height: inner.height, class: "frame" }),
    svg("text", { x: left + inner.width / 2, y: height - 8, "text-anchor": "middle" }, x.label),
    svg("text", { x: 14, y: top + inner.height / 2, "text-anchor": "middle", transform: `rotate(-90 14 ${top + inner.height / 2})` }, y.label),
  );
  drawing.append(title, about, clip, content, axes, above);
  const invert = (px, py) => [
    x.from + ((px - left) / inner.width) * (x.to - x.from),
    y.from + ((top + inner.height - py) / inner.height) * (y.to - y.from),
  ];
  return { drawing, content, above, toX, toY, invert, about, inner, left, top };
}

/** The place of a pointer in the units of a drawing. */
export function pointerPlace(drawing, event) {
  const box = drawing.getBoundingClientRect();
  const [, , width, height] = drawing.getAttribute("viewBox").split(" ").map(Number);
  return [((event.clientX - box.left) / box.width) * width, ((event.clientY - box.top) / box.height) * height];
}
