// Parts of the records: cut by dragging, for training or held out.
import { button, el, fill, seconds, select } from "./dom.js";
import { recordView } from "./columns.js";
import { group, timePlot, zoomButtons } from "./plots.js";
import { current, post } from "./server.js";

const place = document.getElementById("parts");
const FIRST = ["rudder_rad", "yaw_rate_rad_s", "heading_rad", "surge_m_s"];
const ROLES = [{ value: "train", text: "training" }, { value: "held_out", text: "held out" }, { value: "unused", text: "not used" }];
const list = el("div"), plots = el("div"), head = el("div"), tools = el("div");
place.append(
  el("p", { className: "sub" }, "Training parts find the answer, held-out parts test it. Drag over a curve to choose a range; the blue parts are for training, the red ones are held out."),
  head, plots, tools, list);
let shown = "";
let record = 0;
let chosen = null;
let shared = null;
let members = [];
let all = false;

export function show(state) {
  const records = state.log?.records ?? [];
  place.parentElement.hidden = !records.length;
  if (!records.length) { shown = ""; return; }
  record = Math.min(record, records.length - 1);
  const now = JSON.stringify([state.reading, record, all, Boolean(recordView(record))]);
  if (now !== shown) { shown = now; draw(state); }
  rows(state);
  for (const member of members) member.redraw();
}

function draw(state) {
  const { records } = state.log;
  const own = records[record], view = recordView(record);
  chosen = null;
  shared = group();
  fill(head, records.length > 1 ? select("parts-record", "record", records.map((one, i) => ({ value: String(i), text: one.name })),
    String(record), (value) => { record = Number(value); show(current()); }) : null);
  const curves = view?.curves ?? [];
  const wanted = curves.filter((one) => FIRST.includes(one.channel)).sort((a, b) => FIRST.indexOf(a.channel) - FIRST.indexOf(b.channel));
  const drawn = (all || !wanted.length ? curves : wanted).map((one) => el("figure", {},
    el("figcaption", {}, `${one.label}, ${one.unit}`),
    timePlot({
      label: one.label, time: one.time, group: shared, height: 110, chosen: choose,
      curves: [{ label: one.label, values: one.values, colour: "measured" }],
      bands: () => [...bands(), ...(chosen ? [{ ...chosen, role: "chosen" }] : [])],
    })));
  fill(plots, drawn);
  members = [...plots.querySelectorAll(".plot")].map((one) => one.member);
  fill(tools,
    zoomButtons(shared, own.from, own.to, "parts"),
    el("div", { className: "tools", role: "group", "aria-label": "chosen range" },
      number("from", "from, s", own), number("to", "to, s", own),
      button("Add for training", () => add("train"), { id: "add-train" }),
      button("Add as held out", () => add("held_out"), { id: "add-held-out" }),
      button("Propose parts", () => save(current().log.parts), { id: "propose" }),
      button(all ? "Fewer channels" : "All channels", () => { all = !all; show(current()); }, { id: "all-channels", "aria-pressed": String(all) })));
}

function bands() { return current().parts.filter((part) => part.record === record && part.role !== "unused"); }

function number(end, label, own) {
  const input = el("input", { id: `range-${end}`, type: "number", step: "any", value: seconds(own[end]), onchange: () => {
    choose(Number(document.getElementById("range-from").value), Number(document.getElementById("range-to").value), true);
  } });
  return el("label", { htmlFor: `range-${end}`, className: "field" }, el("span", {}, label), input);
}

function choose(from, to, typed = false) {
  const own = current().log.records[record];
  chosen = { from: Math.max(from, own.from), to: Math.min(to, own.to) };
  if (!typed) {
    document.getElementById("range-from").value = chosen.from.toFixed(1);
    document.getElementById("range-to").value = chosen.to.toFixed(1);
  }
  for (const member of members) { member.clear(); member.redraw(); }
}

function add(role) {
  const own = current().log.records[record];
  const from = Number(document.getElementById("range-from").value), to = Number(document.getElementById("range-to").value);
  const taken = new Set(current().parts.map((part) => part.name));
  let count = 1;
  while (taken.has(`${own.name}-part-${count}`)) count += 1;
  const kept = current().parts.filter((part) => part.record !== record || part.to <= from || part.from >= to);
  chosen = null;
  save([...kept, { record, name: `${own.name}-part-${count}`, from, to, role }]);
}

function save(parts) {
  document.getElementById("alert").textContent = "";
  post("/parts", { parts }).catch((error) => { document.getElementById("alert").textContent = error.message; });
}

function rows(state) {
  const change = (i, what) => save(state.parts.map((part, k) => (k === i ? { ...part, ...what } : part)));
  fill(list, el("ul", { className: "parts", "aria-label": "parts" }, state.parts.map((part, i) => el("li", { className: part.role },
    el("span", { className: "name" }, el("b", {}, part.name),
      el("span", { className: "sub" }, `${seconds(part.from)} to ${seconds(part.to)} s`),
      state.log.records[part.record].again ? el("span", { className: "sub" }, state.log.records[part.record].again) : null),
    select(`part-${i}-role`, "for", ROLES, part.role, (role) => change(i, { role }), { "aria-label": `${part.name}: what for` }),
    button("Remove", () => save(state.parts.filter((_, k) => k !== i)), { id: `part-${i}-remove`, "aria-label": `remove ${part.name}` })))));
}
