// Elements from data. Text only ever becomes a text node or an attribute, so nothing in a problem is read as markup.

/** An element: attributes, listeners (onclick: f), and children (elements, texts, lists of these; null is left out). */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? '' : String(value));
  }
  put(element, children);
  return element;
}

function put(element, children) {
  for (const child of children) {
    if (child === null || child === undefined) continue;
    if (Array.isArray(child)) put(element, child);
    else element.append(child instanceof Node ? child : String(child));
  }
}

/** Replaces what an element holds. */
export function fill(element, ...children) {
  element.replaceChildren();
  put(element, children);
}

/** An id or a name from the problem, kept apart from the direction of the text around it. */
export const id = (text) => h('bdi', {class: 'id'}, text);
