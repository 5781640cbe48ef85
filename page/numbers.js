// Numbers as people read them: a limit is rounded towards the safe side.

/** A number with so many digits, rounded "nearest", "down" or "up". */
export function digits(value, count = 4, rounding = "nearest") {
  if (value === 0) return "0";
  if (!Number.isFinite(value)) return value > 0 ? "no limit" : "–";
  const places = count - 1 - Math.floor(Math.log10(Math.abs(value)));
  const scale = 10 ** Math.min(Math.max(places, -12), 12);
  // 99.70000000000001 is 99.7, not one more in the last digit
  const scaled = Number((value * scale).toPrecision(14));
  const whole = { down: Math.floor, up: Math.ceil, nearest: Math.round }[rounding](scaled);
  return String(Number((whole / scale).toPrecision(Math.max(count, 1))));
}

/** A stiffness, N/m. */
export const stiffness = (value, rounding = "nearest") =>
  Number.isFinite(value) ? `${digits(value, 4, rounding)} N/m` : "no limit";

/** A time, s, in ms. */
export const time = (value, rounding = "nearest") =>
  Number.isFinite(value) ? `${digits(value * 1e3, 4, rounding)} ms` : "no limit";

/** JSON has no infinity: a missing number beside a true flag is one. */
export const unbounded = (value, flag) => (value === null && flag ? Infinity : value);

/** A number without the digits that computing has added, for a study file. */
export const clean = (value) => Number(value.toPrecision(12));

/** A round number at or above a value, for the end of a scale. */
export function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((step) => step * power >= value * 0.999999);
}

/** Round numbers from 0 to an end, for ticks. */
export function ticks(end, most = 6) {
  const step = [1, 2, 5, 10].map((each) => each * 10 ** Math.floor(Math.log10(end / most))).find((each) => end / each <= most);
  return Array.from({ length: Math.floor(end / step + 1e-9) + 1 }, (_, i) => clean(i * step));
}

/** Other units of time, in ms. */
const TIMES = { s: 1e3, µs: 1e-3, μs: 1e-3, us: 1e-3 };
const plainUnit = (unit) => unit.replaceAll(/[·⋅*\s]/g, "").normalize("NFKC").toLowerCase();

/**
 * The number that a reader writes for a value with this unit, as "80", "1.5", "1,5", "1e3", "80 ms", or "0.1 s" for one in ms.
 * NaN if it is none: "1,000" may be one or a thousand.
 */
export function written(text, unit) {
  const found = /^([+-]?)(\d+(?:[.,]\d*)?|[.,]\d+)(e[+-]?\d+)?\s*([^\d.,\s].*)?$/i.exec(text.trim().replace("−", "-"));
  if (!found) return NaN;
  const [, sign, size, power = "", own = ""] = found;
  if (/^[1-9]\d{0,2},\d{3}$/.test(size)) return NaN;
  const isOwn = own === "" || plainUnit(own) === plainUnit(unit);
  const factor = isOwn ? 1 : unit === "ms" ? TIMES[own] : undefined;
  return factor === undefined ? NaN : Number(`${sign}${size.replace(",", ".")}${power}`) * factor;
}
