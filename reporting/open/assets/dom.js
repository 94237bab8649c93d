// Elements made from texts: nothing that a log holds is ever taken for markup.

export function el(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name in made && name !== "list" && name !== "form" && !name.startsWith("aria")) made[name] = value;
    else made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return made;
}

export function button(text, onclick, properties = {}) {
  return el("button", { type: "button", onclick, ...properties }, text);
}

export function select(id, label, options, value, onchange, properties = {}) {
  const made = el("select", { id, onchange: () => onchange(made.value), ...properties });
  for (const option of options) {
    if (option.options) made.append(el("optgroup", { label: option.label }, option.options.map(choice)));
    else made.append(choice(option));
  }
  made.value = value;
  return el("label", { htmlFor: id, className: "field" }, el("span", {}, label), made);
}

function choice(option) {
  return el("option", { value: option.value, disabled: option.disabled }, option.text);
}

// Put new content into a place; what had the focus has it again.
export function fill(place, ...children) {
  const focused = document.activeElement?.id;
  const open = new Set([...place.querySelectorAll("details[id][open]")].map((one) => one.id));
  place.replaceChildren(...children.flat(Infinity).filter(Boolean));
  for (const one of place.querySelectorAll("details[id]")) if (open.has(one.id)) one.open = true;
  if (focused && place.querySelector(`[id="${CSS.escape(focused)}"]`)) document.getElementById(focused).focus();
}

export function table(content) {
  const head = content.columns.map((name, place) =>
    el("th", { scope: "col", className: content.numeric[place] ? "number" : "" },
      name ? button(name, () => sort(body, head, place)) : ""));
  const body = el("tbody", {}, content.rows.map((row) =>
    el("tr", {}, row.map((cell, place) => {
      const made = el("td", { className: (content.numeric[place] ? "number " : "") + (cell.text.length > 48 ? "long" : "") },
        cell.text);
      made.dataset.key = cell.key;
      return made;
    }))));
  return el("div", { className: "scroll", tabIndex: 0, role: "region", "aria-label": content.title || "table" },
    el("table", {}, el("thead", {}, el("tr", {}, head)), body));
}

function sort(body, head, place) {
  const way = head[place].getAttribute("aria-sort") === "ascending" ? -1 : 1;
  for (const one of head) one.removeAttribute("aria-sort");
  head[place].setAttribute("aria-sort", way === 1 ? "ascending" : "descending");
  const rows = [...body.rows].sort((a, b) => {
    const x = a.cells[place].dataset.key, y = b.cells[place].dataset.key;
    if (x === "" || y === "") return (x === "") - (y === "");
    const difference = Number(x) - Number(y);
    return way * (Number.isNaN(difference) ? x.localeCompare(y) : difference);
  });
  body.append(...rows);
}

export function bytes(count) {
  return count < 1e6 ? `${Math.max(1, Math.round(count / 1e3))} kB` : `${(count / 1e6).toFixed(1)} MB`;
}

export function range(low, high) {
  const digits = Math.ceil(Math.log10(Math.max(Math.abs(low), Math.abs(high)) / (high - low))) + 3;
  const told = (value) => String(Number(value.toPrecision(Math.min(Math.max(Number.isFinite(digits) ? digits : 5, 5), 15))));
  return `${told(low)} to ${told(high)}`;
}

export function seconds(value) {
  return value === null || Number.isNaN(value) ? "–" : String(Number(Number(value).toFixed(3)));
}

// Equations come as MathML: only its elements and classes are taken over.
const MATH = new Set(["math", "mrow", "mi", "mn", "mo", "mfrac", "msub", "msup", "msubsup", "msqrt", "mroot", "mover",
  "munder", "mtext", "mspace", "mfenced", "mstyle", "mpadded", "mtable", "mtr", "mtd"]);

export function equation(markup) {
  const parsed = new DOMParser().parseFromString(markup, "text/html");
  const copy = (node) => {
    if (node.nodeType === Node.TEXT_NODE) return document.createTextNode(node.textContent);
    const name = node.localName;
    const children = [...node.childNodes].map(copy).filter(Boolean);
    if (name !== "span" && name !== "sup" && name !== "sub" && !MATH.has(name)) {
      const made = document.createDocumentFragment();
      made.append(...children);
      return made;
    }
    const made = MATH.has(name) ? document.createElementNS("http://www.w3.org/1998/Math/MathML", name)
      : document.createElement(name);
    for (const name_ of ["class", "displaystyle"]) if (node.hasAttribute(name_)) made.setAttribute(name_, node.getAttribute(name_));
    made.append(...children);
    return made;
  };
  return [...parsed.body.childNodes].map(copy).filter(Boolean);
}
