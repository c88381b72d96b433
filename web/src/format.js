// Numbers and lists for people.

/** At most six decimals, no trailing zeros, a true minus sign. */
export function number(value) {
  if (value === null || value === undefined) return '–';
  const size = Math.abs(value);
  let text = size !== 0 && (size < 1e-4 || size >= 1e15) ? String(Number(value.toPrecision(6))) : value.toFixed(6).replace(/\.?0+$/, '');
  if (text === '-0') text = '0';
  return text.replace('-', '−');
}

/** The same for a column: all with as many decimals as the one that needs most. */
export function column(values) {
  const decimals = Math.max(0, ...values.map((value) => (number(value).split('.')[1] ?? '').length));
  return values.map((value) => (value === null ? '–' : value.toFixed(Math.min(decimals, 6)).replace(/^-(0(\.0+)?)$/, '$1').replace('-', '−')));
}

const grouping = new Intl.NumberFormat('en-GB');
export const grouped = (value) => grouping.format(value);

export const counted = (value, noun) => `${grouped(value)} ${noun}${value === 1 ? '' : 's'}`;

const constraintNames = {
  precedence: 'Precedence',
  precedence_any: 'Precedence',
  max_subassemblies: 'Subassemblies',
  max_moved_parts: 'Moved parts',
  max_moved_mass: 'Moved mass',
  blocking: 'Blocking',
  not_open: 'Order',
  axis: 'Axis',
  robots: 'Robots',
  cut: 'Cut',
  motion: 'Motion',
  motions: 'Motion',
  places: 'Places',
  distance: 'Distance',
  end: 'End',
};
export const constraintName = (name) => constraintNames[name] ?? name;
