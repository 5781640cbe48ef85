// The whole study in the page's address, behind the #: base64url of its text.

const KEY = "study=";

/** The part of an address after # that holds a study. */
export function toHash(text) {
  let binary = "";
  for (const byte of new TextEncoder().encode(text)) binary += String.fromCharCode(byte);
  return `#${KEY}${btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "")}`;
}

/** The study in an address; null if there is none, or it is damaged. */
export function fromHash(hash) {
  const at = hash.indexOf(KEY);
  if (at < 0) return null;
  try {
    const binary = atob(hash.slice(at + KEY.length).replaceAll("-", "+").replaceAll("_", "/"));
    return new TextDecoder("utf-8", { fatal: true }).decode(Uint8Array.from(binary, (letter) => letter.charCodeAt(0)));
  } catch {
    return null;
  }
}
