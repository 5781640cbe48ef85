// Elements of SVG and HTML.

/** The namespace of SVG. */
export const SPACE = "http://www.w3.org/2000/svg";

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
