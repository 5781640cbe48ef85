// Drawing in SVG, and a drawing as a file of its own.

const SPACE = "http://www.w3.org/2000/svg";

/** An SVG element with attributes and children. */
export function svg(name, attributes = {}, ...children) {
  const element = document.createElementNS(SPACE, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
}

/** An HTML element with properties and children. */
export function html(name, properties = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key in element && !key.startsWith("aria")) element[key] = value;
    else element.setAttribute(key, value);
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

/** The path through points, [x, y] each; null lifts the pen. */
export function pathOf(points) {
  let path = "";
  let isDown = false;
  for (const point of points) {
    if (point === null) isDown = false;
    else {
      path += `${isDown ? "L" : "M"}${point[0].toFixed(2)} ${point[1].toFixed(2)}`;
      isDown = true;
    }
  }
  return path;
}

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
