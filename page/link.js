// The whole study in the page's address, behind the #: base64url of its text.

const KEY = "study=";
/** How many bytes the study has, before it: a link that was cut is no other study. */
const SIZE = "bytes=";
/** What stands for the study of an address that holds none that is whole. */
export const DAMAGED = Symbol("damaged");

/** The part of an address after # that holds a study. */
export function toHash(text) {
  let binary = "";
  const bytes = new TextEncoder().encode(text);
  for (const byte of bytes) binary += String.fromCharCode(byte);
  return `#${SIZE}${bytes.length}&${KEY}${btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "")}`;
}

/** The study in an address; null if there is none, `DAMAGED` if it is not whole. */
export function fromHash(hash) {
  const at = hash.indexOf(KEY);
  const size = /[#&]bytes=(\d+)/.exec(hash);
  if (at < 0) return size ? DAMAGED : null;
  try {
    const binary = atob(hash.slice(at + KEY.length).replaceAll("-", "+").replaceAll("_", "/"));
    if (binary === "" || (size && Number(size[1]) !== binary.length)) return DAMAGED;
    return new TextDecoder("utf-8", { fatal: true }).decode(Uint8Array.from(binary, (letter) => letter.charCodeAt(0)));
  } catch {
    return DAMAGED;
  }
}
