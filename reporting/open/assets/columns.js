// Every column of the logs: what it was taken for, why, and what would change it; beside them the track, drawn live.
import { button, el, fill, range, select } from "./dom.js";
import { group, key, lying, pairPlot, spark, timePlot, trackPlot, zoomButtons } from "./plots.js";
import { address, current, get, post, running } from "./server.js";

const place = document.getElementById("columns");
let about = null;
let drawn = { reading: "", columns: {}, records: {} };
let shown = "";
let record = 0;

export function start(known) { about = known; }

export async function show(state) {
  const log = state.log;
  place.parentElement.hidden = !log;
  if (!log) { shown = ""; return; }
  const now = JSON.stringify([state.reading, state.choices, state.answers, state.positive_rudder, log.line, log.questions.length]);
  if (now === shown) return;
  shown = now;
  if (drawn.reading !== state.reading) await load(state);
  render(current());
}

async function load(state) {
  const found = { reading: state.reading, columns: {}, records: {} };
  for (const one of await get(address("/columns")).catch(() => [])) found.columns[`${one.table}\n${one.column}`] = one;
  for (let i = 0; i < Math.min(state.log.records.length, 50); i += 1) {
    found.records[i] = await get(address(`/records/${i}`)).catch(() => null);
  }
  drawn = found;
}

export function recordView(number) { return drawn.records[number]; }

function render(state) {
  const { log } = state;
  const fatal = log.faults.filter((fault) => fault.fatal), other = log.faults.filter((fault) => !fault.fatal);
  const parts = [];
  if (log.line) parts.push(el("p", { className: "warn", id: "log-line" }, `No record yet: ${log.line}.`.replace(/\.\.$/, ".")));
  parts.push(questions(state), answered(state));
  parts.push(list("What keeps the log from being a record", fatal), list("To be looked at", other));
  const several = new Set(log.columns.map((one) => one.table)).size > 1;
  parts.push(el("div", { className: "two" },
    el("ul", { className: "columns", "aria-label": "columns" }, log.columns.map((one, i) => column(state, one, i, several))),
    el("div", { className: "live" }, live(state), pair(state))));
  if (log.steps.length) {
    parts.push(el("details", { id: "steps" }, el("summary", {}, "What was done"), el("ul", {}, log.steps.map((step) => el("li", {}, step)))));
  }
  fill(place, parts);
}

function list(title, faults) {
  if (!faults.length) return null;
  return el("details", { id: `faults-${title.length}`, open: faults.length < 6 }, el("summary", {}, `${title} (${faults.length})`),
    el("ul", {}, faults.map((fault) => el("li", {},
      [fault.table, fault.row === null ? "" : `row ${fault.row}`, fault.column ?? "", fault.message].filter(Boolean).join(": "),
      fault.hint ? el("span", { className: "sub" }, `: ${fault.hint}`) : null))));
}

const NOT_USED = "not used", TIME = "time";

function column(state, one, i, several) {
  const values = drawn.columns[`${one.table}\n${one.column}`]?.values ?? [];
  const told = state.choices.some(([name, title]) => name === one.table && title === one.column);
  const used = one.quantity !== NOT_USED, curve = values.some((value) => value !== null);
  const examples = one.smallest === null ? one.samples : [range(one.smallest, one.largest)];
  return el("li", { className: `column${used ? "" : " aside"}${one.questions.length ? " open" : ""}` },
    el("div", { className: curve ? "name" : "name wide" }, el("b", {}, one.column || "(no name)"),
      several ? el("span", { className: "sub" }, one.table) : null,
      examples.map((value) => el("span", { className: "sub" }, value))),
    curve ? spark(values) : null,
    el("div", { className: "choices" }, inParts(state, one) ? el("p", { className: "sub" }, `time (${one.unit})`) : controls(one, i)),
    el("p", { className: "sub why" }, sampled(one), told ? "as you say" : [one.sign, one.why].filter(Boolean).join("; "),
      told || !used ? null : el("b", {}, ` (${one.sure})`)),
    one.questions.length ? el("p", { className: "sub why" }, "asked above") : null);
}

// How a column of numbers was sampled.
function sampled(one) {
  if (one.smallest === null) return null;
  const share = 100 * one.missing;
  const missing = share === 0 ? "none missing" : `${share < 0.1 ? "less than 0.1" : Number(share.toPrecision(2))} % missing`;
  return el("span", { className: "sampled" }, [`${one.rows} rows`, one.rate === null ? "" : `${Number(one.rate.toPrecision(3))} Hz`, missing].filter(Boolean).join(", "));
}

// Whether a column is one of several that are the time together.
function inParts(state, one) {
  return one.quantity === TIME && state.log.columns.filter((row) => row.table === one.table && row.quantity === TIME).length > 1;
}

// A time stays one until another column is said to be it.
function controls(one, i) {
  const quantity = about.quantities[one.quantity] ? one.quantity : NOT_USED;
  const name = one.column || "(no name)";
  const units = quantity === NOT_USED ? [] : about.quantities[quantity];
  const kinds = [NOT_USED, ...Object.keys(about.quantities)].map((value) => ({ value, text: value.replaceAll("_", " ") }));
  const choose = (change) => say(one, { to: quantity, unit: one.unit || units[0] || "", sign: one.factor, ...change });
  const open = one.unit === "" ? [{ value: "", text: "?" }] : [];
  return [
    select(`column-${i}-to`, "is", quantity === TIME ? [{ value: TIME, text: TIME }] : kinds, quantity, (to) => choose({ to, unit: (about.quantities[to] ?? [""])[0], sign: 1 }),
      { "aria-label": `${name}: quantity` }),
    units.length ? select(`column-${i}-unit`, quantity === TIME ? "form" : "unit", [...open, ...units.map((value) => ({ value, text: value }))], one.unit,
      (unit) => choose({ unit }), { "aria-label": `${name}: ${quantity === TIME ? "form" : "unit"}` }) : null,
    units.length && quantity !== TIME ? button("±", () => choose({ sign: -one.factor }),
      { id: `column-${i}-sign`, title: "turn the sign", "aria-pressed": String(one.factor < 0), "aria-label": `${name}: turn the sign` }) : null,
  ];
}

// ---- what no one states: every question of the log, wherever it stands, and the answers that were given

const MOST_BUTTONS = 6;

function questions(state) {
  if (!state.log.questions.length) return null;
  return el("div", { id: "questions" }, state.log.questions.map((asked, i) => question(state, asked, `question-${i}`)));
}

function question(state, asked, id) {
  const answer = (key) => read({ ...current().answers, [asked.id]: key });
  const many = asked.answers.length > MOST_BUTTONS;
  const number = el("input", { id: `${id}-number`, type: "number", step: "any" });
  return el("div", { className: "question", role: "group", "aria-label": `question about ${asked.column || "the log"}` },
    el("p", { className: asked.about === "columns" ? "plain" : "" }, asked.text),
    asked.about === "columns" ? proposal(state, asked) : asked.about === "file" ? null : numbersOf(state, asked),
    many ? select(`${id}-answer`, "answer", [{ value: "", text: "choose" }, ...asked.answers.map((one) => ({ value: one.key, text: one.text }))],
      state.answers[asked.id] ?? "", (key) => { if (key) answer(key); })
      : asked.answers.map((one, k) => button(one.text, () => answer(one.key),
        { id: `${id}-answer-${k}`, title: one.line, "aria-pressed": String(state.answers[asked.id] === one.key) })),
    asked.number ? [el("label", { htmlFor: `${id}-number`, className: "field" }, el("span", { title: asked.number }, asked.number.split(": ")[0]), number),
      button("Take this number", () => { if (number.value !== "") answer(number.value); }, { id: `${id}-take` })] : null);
}

// The column that a question is about: its curve and its numbers.
function numbersOf(state, asked) {
  const one = state.log.columns.find((row) => row.table === asked.table && row.column === asked.column);
  if (!one || one.smallest === null) return null;
  return [spark(drawn.columns[`${one.table}\n${one.column}`]?.values ?? []),
    el("span", { className: "sub" }, `${one.column}: ${range(one.smallest, one.largest)}`)];
}

// What the draft takes the columns of a table for.
function proposal(state, asked) {
  const rows = state.log.columns.filter((one) => one.table === asked.table);
  const cell = (text) => el("td", {}, text);
  return el("div", { className: "scroll", tabIndex: 0, role: "region", "aria-label": "the columns as proposed" }, el("table", { className: "proposal" },
    el("thead", {}, el("tr", {}, ["column", "is", "unit", "", "from and to", "why"].map((name) => el("th", { scope: "col" }, name)))),
    el("tbody", {}, rows.map((one) => el("tr", { className: one.quantity === NOT_USED ? "aside" : "" },
      el("th", { scope: "row" }, one.column), cell(one.quantity.replaceAll("_", " ")), cell(one.unit), el("td", {}, spark(drawn.columns[`${one.table}\n${one.column}`]?.values ?? [])),
      cell(one.smallest === null ? one.samples[0] ?? "" : range(one.smallest, one.largest)), cell(one.why))))));
}

function answered(state) {
  if (!state.answered.length) return null;
  const before = (i) => Object.fromEntries(Object.entries(state.answers).slice(0, i));
  return el("details", { id: "answered" }, el("summary", {}, `What you answered (${state.answered.length})`), el("ul", {}, state.answered.map((one) =>
    el("li", {}, `${one.text} `, el("b", {}, one.answer), " ",
      button("Take back", () => read(before(Object.keys(state.answers).indexOf(one.id))), { className: "link", title: "this answer and those after it", "aria-label": `take back: ${one.answer}` })))));
}

function say(one, what) {
  const choices = current().choices.filter(([name, title]) => name !== one.table || title !== one.column);
  read(current().answers, [...choices, [one.table, one.column, what]]);
}

export function read(answers = current().answers, choices = current().choices, side = current().positive_rudder) {
  document.getElementById("alert").textContent = "";
  return post("/read", { answers, choices, positive_rudder: side }).catch(alertOf);
}

function alertOf(error) { document.getElementById("alert").textContent = error.message; }

// ---- the track and the heading by channels that must agree

const TRACKS = { positions: "measured", "speed and heading": "after", "speed and yaw rate": "before" };

function live(state) {
  const { records } = state.log;
  if (!records.length) return [el("p", { className: "sub" }, running() ? "Reading …" : "The track appears when the columns make a record.")];
  record = Math.min(record, records.length - 1);
  const view = drawn.records[record];
  const side = state.log.records[record].positive_rudder;
  const head = [
    records.length > 1 ? select("live-record", "record", records.map((one, i) => ({ value: String(i), text: one.name })), String(record),
      (value) => { record = Number(value); render(current()); }) : null,
    select("rudder-side", "a positive rudder turns the ship to",
      [{ value: "", text: `by the yaw response${side ? `: ${side}` : ""}` }, { value: "port", text: "port" }, { value: "starboard", text: "starboard" }],
      state.positive_rudder ?? "", (value) => read(undefined, undefined, value || null)),
  ];
  if (!view) return head;
  const shared = group();
  const out = [...head];
  if (view.tracks.length) {
    const tracks = view.tracks.map((one) => ({ ...one, colour: TRACKS[one.label], dash: one.label === "positions" ? "" : "6 3" }));
    out.push(el("h3", {}, "Track"), key(tracks), agreeing(tracks), trackPlot({ label: "track", tracks, group: shared, time: tracks[0].time }));
  }
  if (view.headings) {
    const curves = [{ label: "heading", values: view.headings.heading, colour: "measured" },
      { label: "by the yaw rate", values: view.headings.yaw_rate, colour: "before", dash: [6, 3] }];
    out.push(el("h3", {}, "Heading, deg"), key(curves), agreeing(curves), timePlot({ label: "heading", time: view.headings.time, curves, group: shared, height: 140 }));
  }
  out.push(el("p", { className: "sub" }, "Lines that leave each other show a wrong sign or unit, or an offset of a sensor."));
  const own = state.log.records[record];
  out.push(zoomButtons(shared, own.from, own.to, "live"));
  return out;
}

function agreeing(curves) {
  const told = lying(curves);
  return told ? el("p", { className: "sub" }, told) : null;
}

// ---- two columns in one plot

let pairOf = [];

function pair(state) {
  const shown_ = state.log.columns.filter((one) => one.smallest !== null && one.smallest < one.largest);
  const name = (one) => `${one.table}\n${one.column}`;
  const names = shown_.map(name);
  if (names.length < 2) return null;
  const first = (...kinds) => names[shown_.findIndex((one) => kinds.includes(one.quantity))];
  const own = [first("rudder", "rudder_command") ?? names[0], first("yaw_rate") ?? first("heading") ?? names[1]].map((usual, i) =>
    (names.includes(pairOf[i]) ? pairOf[i] : usual));
  const several = new Set(shown_.map((one) => one.table)).size > 1;
  const options = shown_.map((one) => ({ value: name(one), text: several ? `${one.column} (${one.table})` : one.column }));
  const choose = (i) => (value) => { pairOf = own.map((old, k) => (k === i ? value : old)); render(current()); };
  const curves = own.map((key_) => ({ label: options.find((one) => one.value === key_).text, ...drawn.columns[key_] }));
  return el("details", { id: "pair" }, el("summary", {}, "Two columns in one plot"),
    el("div", { className: "tools" }, select("pair-0", "left axis", options, own[0], choose(0)), select("pair-1", "right axis", options, own[1], choose(1))),
    curves.every((one) => one.values) ? [key(curves.map((one, i) => ({ label: one.label, colour: ["measured", "before"][i] }))), pairPlot(...curves)] : null,
    el("p", { className: "sub" }, "Over time in s from the first sample, or over rows where no time is known or it starts again; numbers as they stand in the file."));
}
