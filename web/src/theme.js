// Colours of what is drawn, read from the style sheet so that there is one list of them; and the switch.

const listeners = [];
const dark = matchMedia('(prefers-color-scheme: dark)');
const print = matchMedia('print');
let chosen = null;  // by the switch: "light" or "dark"
let printing = false;

const variable = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

export const isDark = () => !printing && (chosen ?? (dark.matches ? 'dark' : 'light')) === 'dark';

function apply() {
  document.documentElement.dataset.theme = isDark() ? 'dark' : 'light';
  palette = null;
  for (const listener of listeners) listener();
}

/** Calls `listener` whenever the colours change. */
export function onTheme(listener) {
  listeners.push(listener);
}

export function toggleTheme() {
  chosen = isDark() ? 'light' : 'dark';
  apply();
}

const printListeners = [];

/** Calls `listener` before the page is printed, when its colours are those of paper. */
export function onPrint(listener) {
  printListeners.push(listener);
}

/** A printed page is light. */
function setPrinting(value) {
  if (printing === value) return;
  printing = value;
  apply();
  if (printing) for (const listener of printListeners) listener();
}

export function startTheme() {
  dark.addEventListener('change', apply);
  print.addEventListener('change', () => setPrinting(print.matches));
  addEventListener('beforeprint', () => setPrinting(true));
  addEventListener('afterprint', () => setPrinting(false));
  printing = print.matches;
  apply();
}

let palette = null;

/** The colours now; read from the style sheet once for each theme. */
export function colours() {
  palette ??= {
    ink: variable('ink'),
    muted: variable('muted'),
    line: variable('line'),
    surface: variable('surface'),
    accent: variable('accent'),
    warn: variable('warn'),
    onPiece: variable('on-piece'),
    pieces: [0, 1, 2, 3, 4, 5, 6].map((i) => variable(`piece-${i}`)),
  };
  return palette;
}

/** The colour of a piece: the first one is plain, the others take turns. */
export const pieceColour = ({pieces}, label) => pieces[label === 0 ? 0 : 1 + ((label - 1) % 6)];
