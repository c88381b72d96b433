// Parts that are the same thing: "3 × M5 nut".

/** An id without the number that tells equal parts apart: "M5 nut.2" is an "M5 nut". */
function stem(ident, weighed) {
  const match = /^(.*?[^ ._#:~-])(?:[._#:~-]\d+| ?\(\d+\)| \d+)$/.exec(ident);
  if (!match) return ident;
  // "Profile 20" and "Profile 40" are two things, unless they weigh the same.
  return / \d+$/.test(ident) && !weighed ? ident : match[1];
}

/** For each part the number of its kind, and for each kind its name. Equal parts have the same product, where they state one; else one name, or ids that differ in a number at the end, and weigh the same. */
export function kindsOf(problem) {
  const byKey = new Map();
  const kinds = [];
  // What others are called after keeps its number: "Bearing 16 x 5" where there is a "Bearing 16 x 5 2".
  const ids = new Set(problem.parts.map(([ident]) => ident));
  const bases = new Set(problem.parts.flatMap(([ident, name, mass]) => [name, stem(ident, mass !== 1)].filter((base) => base !== ident && ids.has(base))));
  const of = problem.parts.map(([ident, name, mass, , product], part) => {
    const called = product ? product : name && name !== ident ? name : bases.has(ident) ? ident : stem(ident, mass !== 1);
    const key = JSON.stringify(product ? [product] : [called, mass === null ? null : Number(mass.toPrecision(6))]);
    if (!byKey.has(key)) {
      byKey.set(key, kinds.length);
      kinds.push({name: called, parts: []});
    }
    kinds[byKey.get(key)].parts.push(part);
    return byKey.get(key);
  });
  for (const kind of kinds) {
    const [ident, name] = problem.parts[kind.parts[0]];
    if (kind.parts.length === 1) kind.name = name || ident;
  }
  return {of, kinds};
}

/** These parts by kind, in order: {name, parts}. */
export function byKind({of, kinds}, parts) {
  const found = new Map();
  for (const part of parts) {
    if (!found.has(of[part])) found.set(of[part], {name: kinds[of[part]].name, parts: []});
    found.get(of[part]).parts.push(part);
  }
  return [...found.values()];
}

/** "3 × M5 nut" or "plate". */
export const kindText = ({name, parts}) => (parts.length > 1 ? `${parts.length} × ${name}` : name);
